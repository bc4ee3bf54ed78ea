"""The live page: what a browser on this machine sees of a running daemon, and what it may ask for with the token."""

from gimbal_hil.dashboard.screen import ScopeScreen
from gimbal_hil.dashboard.server import PageServer

__all__ = ["PageServer", "ScopeScreen"]
