"""The live page and the metrics of a running daemon, served by its service process on the loopback address."""

from gimbal_hil.dashboard.server import PageServer

__all__ = ["PageServer"]
