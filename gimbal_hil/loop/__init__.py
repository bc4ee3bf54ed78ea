"""The loop: what happens in one tick, and when the next one is due.

control   the control law: cascade PI, observer, compensation; pure compiled functions
host      supervisor and control of one antenna, from mail to mail: states, guards, segments
settings  the daemon's configuration, validated once, and the host's array made of it
timing    clocks, deadlines, causes of missed ones, the witness process, rings between processes

Below every other district; knows wire and device, no run folder, no file but the configuration.
"""
