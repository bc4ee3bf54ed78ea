"""Realtime: a running antenna, and the people beside it.

lockstep   host and virtual antenna bound by sequence number: virtual time in place of the wall clock
telemetry  records from the control process to other processes, and the live view
operator   the operator's socket: the daemon's side and the client
observing  the model beside the running antenna
dashboard  live page and metrics
foxglove   what a daemon does, live, for Foxglove and PlotJuggler
mavlink    the antenna as a gimbal for autopilots and ground stations
service    the process beside the control process: recorder, operator's desk, page
daemon     the control process: loop, link, reconnection

Nothing here can delay a tick; what is learned from the data lies in knowledge.
"""
