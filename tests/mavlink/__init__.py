"""MAVLink's gimbal protocol, spoken by the library of the protocol's own authors."""
