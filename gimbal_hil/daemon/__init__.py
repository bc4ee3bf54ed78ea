"""The control daemon: tick engine, control process, service process and operator commands."""
