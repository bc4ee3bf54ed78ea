"""The virtual antenna: rigid body, friction, actuator, sensors, effects, and the firmware in front of them.

What other packages may import is these modules and the folders `model`, `effects`, `device` and `server`; none is
imported here, because most are compiled.
"""

__all__ = [
    "base_motion",
    "boresight",
    "c_compiler",
    "carrying",
    "firmware_run",
    "friction",
    "friction_in_force",
    "layout",
    "noise",
    "observer",
    "plant",
    "rigid_body",
    "sensors",
    "shipped",
    "step",
    "stribeck_expansion",
    "thesis_slips",
]
