"""The host: supervisor and control of one antenna, from block to block or from mail to mail."""

from gimbal_hil.control.layout import Mode
from gimbal_hil.host.events import HostEvent
from gimbal_hil.host.host import Host
from gimbal_hil.host.program import AxisCommand, EndCondition, Guard, Program, Segment, program_of
from gimbal_hil.host.states import Cause, EndKind, EventCode, HostState, LinkStatus, Origin, Shape

__all__ = [
    "AxisCommand",
    "Cause",
    "EndCondition",
    "EndKind",
    "EventCode",
    "Guard",
    "Host",
    "HostEvent",
    "HostState",
    "LinkStatus",
    "Mode",
    "Origin",
    "Program",
    "Segment",
    "Shape",
    "program_of",
]
