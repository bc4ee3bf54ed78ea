"""Foxglove: a running daemon as a live source for Foxglove, PlotJuggler and whoever speaks Foxglove's websocket
protocol.

`serve` is a client of the daemon that looks and never commands; the SDK sends what it sees. `layout_of` is a layout for
Foxglove that shows it.
"""

from gimbal_hil.realtime.foxglove.layout import layout_of
from gimbal_hil.realtime.foxglove.server import FoxgloveServer, serve
from gimbal_hil.realtime.foxglove.telling import axis_message, log_level, rotations, state_message

__all__ = ["FoxgloveServer", "axis_message", "layout_of", "log_level", "rotations", "serve", "state_message"]
