"""The virtual antenna: rigid body, friction, actuator, sensors, effects, and the firmware in front of them."""
