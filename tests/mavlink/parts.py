"""A gimbal without a daemon, and messages as another component sends them: packed and parsed by pymavlink."""

from __future__ import annotations

import math
import os
from typing import Any

# read when the library is imported
os.environ.setdefault("MAVLINK20", "1")

from pymavlink import mavutil
from pymavlink.dialects.v20 import common as dialect

from gimbal_hil.realtime.mavlink import Gimbal, Reach, Seen

__all__ = [
    "NAN",
    "REACH",
    "STATION",
    "command",
    "dialect",
    "gimbal",
    "heartbeat",
    "mavutil",
    "pitch_yaw",
    "seen",
    "sent",
]
NAN = math.nan
STATION = (255, 190)
REACH = Reach((-3.0, -1.5), (7.0, 0.5), (2.0, 1.0), (1.0, -1.0))


def gimbal(reach: Reach = REACH) -> Gimbal:
    return Gimbal(dialect, reach, 1, 154)


def sent(message: Any, sender: tuple[int, int] = STATION) -> Any:
    """The message as it arrives, with its sender."""
    there = dialect.MAVLink(None, *sender)
    packed = message.pack(there)
    return dialect.MAVLink(None).parse_buffer(packed)[-1]


def heartbeat(sender: tuple[int, int] = STATION) -> Any:
    return sent(dialect.MAVLink_heartbeat_message(dialect.MAV_TYPE_GCS, 8, 0, 0, 4, 3), sender)


def command(number: int, *parameters: float, sender: tuple[int, int] = STATION) -> Any:
    seven = [*parameters, *[0.0] * (7 - len(parameters))]
    return sent(dialect.MAVLink_command_long_message(1, 154, number, 0, *seven), sender)


def pitch_yaw(
    pitch_rad: float,
    yaw_rad: float,
    flags: int = 0,
    rates: tuple[float, float] = (NAN, NAN),
    sender: tuple[int, int] = STATION,
) -> Any:
    message = dialect.MAVLink_gimbal_manager_set_pitchyaw_message(1, 154, flags, 1, pitch_rad, yaw_rad, *rates)
    return sent(message, sender)


def seen(
    position: tuple[float, float] = (0.0, 0.0),
    base: tuple[float, float, float] | None = None,
    mode: str = "position",
    **other: Any,
) -> Seen:
    told = {"active": True, "linked": True, "guard": "", "drive_fault": "none"} | other
    return Seen(1.0, position, (0.0, 0.0), mode=mode, base_rad=base, **told)
