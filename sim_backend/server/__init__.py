"""Serving the virtual antenna in real time on a link."""

from sim_backend.server.lockstep import LockstepServer
from sim_backend.server.outlet import Outlet, OutletKind, join_bus, open_outlet, parse_outlet
from sim_backend.server.schedule import TickCause, TickSchedule
from sim_backend.server.serving import DeviceServer, ServingStatistics

__all__ = [
    "DeviceServer",
    "LockstepServer",
    "Outlet",
    "OutletKind",
    "ServingStatistics",
    "TickCause",
    "TickSchedule",
    "join_bus",
    "open_outlet",
    "parse_outlet",
]
