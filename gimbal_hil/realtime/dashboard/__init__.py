"""The live page of a running daemon for a browser on this machine, and the requests that it may send with the token."""

from gimbal_hil.realtime.dashboard.screen import ScopeScreen
from gimbal_hil.realtime.dashboard.server import PageServer

__all__ = ["PageServer", "ScopeScreen"]
