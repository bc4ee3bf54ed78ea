"""The host: supervisor and control of one antenna, from block to block or from mail to mail."""

from gimbal_hil.loop.control.layout import Mode
from gimbal_hil.loop.host import layout
from gimbal_hil.loop.host.core import host_tick
from gimbal_hil.loop.host.events import AXIS_NAMES, HostEvent, word_of
from gimbal_hil.loop.host.first_test import FirstTest, FirstTestState
from gimbal_hil.loop.host.frame_tick import encode_host_mail, host_block_tick
from gimbal_hil.loop.host.guard_table import DRIVE_GUARDS, HOST_GUARDS
from gimbal_hil.loop.host.host import Host
from gimbal_hil.loop.host.image import IMAGE_WORDS, image_of, stand_as
from gimbal_hil.loop.host.layout import LEAST_BRAKING_SHARE, MOMENTUM_WINDOW_S
from gimbal_hil.loop.host.memory import (
    C_AT,
    COUNTERS_AT,
    H_AT,
    HOST_OCTETS,
    MAIL_AT,
    OCTETS_AT,
    RECEIVERS_AT,
    ROWS_KEPT,
    SENT_AT,
)
from gimbal_hil.loop.host.program import UNNAMED, AxisCommand, EndCondition, Guard, Program, Segment, program_of
from gimbal_hil.loop.host.states import (
    GUARD_CAUSES,
    EndKind,
    EventCode,
    HostCause,
    HostState,
    LinkStatus,
    PointingState,
    ReferenceOrigin,
    Shape,
    UnnamedAxis,
)
from gimbal_hil.loop.host.tick_row import LOG_WORDS, MEASURED, ROW_WORDS, write_row

__all__ = [
    "AXIS_NAMES",
    "COUNTERS_AT",
    "C_AT",
    "DRIVE_GUARDS",
    "GUARD_CAUSES",
    "HOST_GUARDS",
    "HOST_OCTETS",
    "H_AT",
    "IMAGE_WORDS",
    "LEAST_BRAKING_SHARE",
    "LOG_WORDS",
    "MAIL_AT",
    "MEASURED",
    "MOMENTUM_WINDOW_S",
    "OCTETS_AT",
    "RECEIVERS_AT",
    "ROWS_KEPT",
    "ROW_WORDS",
    "SENT_AT",
    "UNNAMED",
    "AxisCommand",
    "EndCondition",
    "EndKind",
    "EventCode",
    "FirstTest",
    "FirstTestState",
    "Guard",
    "Host",
    "HostCause",
    "HostEvent",
    "HostState",
    "LinkStatus",
    "Mode",
    "PointingState",
    "Program",
    "ReferenceOrigin",
    "Segment",
    "Shape",
    "UnnamedAxis",
    "encode_host_mail",
    "host_block_tick",
    "host_tick",
    "image_of",
    "layout",
    "program_of",
    "stand_as",
    "word_of",
    "write_row",
]
