"""What the antenna tells over MAVLink: its attitude, its abilities, who is in control, what is wrong."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from gimbal_hil.realtime.mavlink.angles import quaternion
from gimbal_hil.realtime.mavlink.values import Reach, Seen

#: system and component
Sender = tuple[int, int]
#: the device's number where it is one component with its manager: 1 to 6
DEVICE = 1
#: nearer to a limit than this counts as there, rad
_AT_LIMIT_RAD = 0.01
_POWER = ("undervoltage",)
_ENCODERS: tuple[str, ...] = (
    "encoder",
    "gyro",
    "sensors_disagree",
    "sensor_stuck",
    "gyro_stuck",
    "gyro_encoder_disagree",
)
_ENCODERS += ("sensor_drift", "feedback_frozen", "position_jump")
_SOFTWARE = ("internal", "not_a_number", "wrong_antenna", "synchronisation_timeout", "set_point_lost")
_COMMUNICATION = ("communication", "feedback_lost", "deadman", "attitude_lost")


@dataclass(frozen=True, slots=True)
class InControl:
    """Who is in control, first and second, and the place (RETRACT or NEUTRAL) that was asked for last, or 0."""

    controller: Sender
    second: Sender
    place: int


class Telling:
    """Makes messages; `dialect` is pymavlink's common dialect."""

    def __init__(self, dialect: ModuleType, reach: Reach, name: str) -> None:
        self._m, self._reach, self._name = dialect, reach, name

    def message(self, name: str, seen: Seen, held: InControl) -> Any:
        """One message of the antenna by its name."""
        m, milliseconds = self._m, int(seen.time_s * 1e3) & 0xFFFFFFFF
        if name == "HEARTBEAT":
            state = m.MAV_STATE_CRITICAL if seen.guard or not seen.linked else m.MAV_STATE_STANDBY
            return m.MAVLink_heartbeat_message(
                m.MAV_TYPE_GIMBAL, m.MAV_AUTOPILOT_INVALID, 0, 0, m.MAV_STATE_ACTIVE if seen.active else state, 3
            )
        if name == "GIMBAL_DEVICE_ATTITUDE_STATUS":
            return self._attitude_status(seen, milliseconds, held.place)
        if name == "GIMBAL_MANAGER_STATUS":
            return m.MAVLink_gimbal_manager_status_message(
                milliseconds, self._flags(seen, held.place), DEVICE, *held.controller, *held.second
            )
        if name == "GIMBAL_MANAGER_INFORMATION":
            return m.MAVLink_gimbal_manager_information_message(
                milliseconds, self._abilities(), DEVICE, *self._ranges()
            )
        return m.MAVLink_gimbal_device_information_message(
            milliseconds,
            b"gimbal-hil",
            b"two-axis antenna",
            self._name.encode("ascii", "replace")[:32],
            0,
            0,
            0,
            self._abilities(),
            0,
            *self._ranges(),
            gimbal_device_id=DEVICE,
            cap_flags2=self._abilities(),
        )

    def _abilities(self) -> int:
        words: tuple[str, ...] = ("HAS_RETRACT", "HAS_NEUTRAL", "HAS_PITCH_AXIS", "HAS_PITCH_FOLLOW", "HAS_PITCH_LOCK")
        words += ("HAS_YAW_AXIS", "HAS_YAW_FOLLOW", "HAS_YAW_LOCK", "SUPPORTS_YAW_IN_EARTH_FRAME")
        able = sum(getattr(self._m, f"GIMBAL_DEVICE_CAP_FLAGS_{word}") for word in words)
        if math.isinf(self._reach.high_rad[0] - self._reach.low_rad[0]):
            able += self._m.GIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_INFINITE_YAW
        return int(able)

    def _ranges(self) -> tuple[float, ...]:
        """Limits of roll, pitch and yaw, least and largest; MAVLink turns the other way."""
        (outer_low, inner_low), (outer_high, inner_high) = self._reach.low_rad, self._reach.high_rad
        return (0.0, 0.0, -inner_high, -inner_low, -outer_high, -outer_low)

    def _flags(self, seen: Seen, place: int) -> int:
        m = self._m
        flags = place if seen.active else 0
        if seen.held_in_space:
            flags |= m.GIMBAL_DEVICE_FLAGS_PITCH_LOCK | m.GIMBAL_DEVICE_FLAGS_YAW_LOCK
        in_earth = seen.held_in_space and seen.base_rad is not None
        frame = m.GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME if in_earth else m.GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME
        return int(flags | frame)

    def _attitude_status(self, seen: Seen, milliseconds: int, place: int) -> Any:
        flags = self._flags(seen, place)
        from_north = bool(flags & self._m.GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME)
        known = all(math.isfinite(value) for value in seen.position_rad)
        q = quaternion(seen.position_rad, seen.base_rad, from_north) if known else (math.nan,) * 4
        heading = math.nan if seen.base_rad is None else -seen.base_rad[2]
        return self._m.MAVLink_gimbal_device_attitude_status_message(
            0,
            0,
            milliseconds,
            flags,
            q,
            math.nan,
            -seen.rate_rad_s[1],
            -seen.rate_rad_s[0],
            self._failures(seen),
            heading,
            math.nan,
            DEVICE,
        )

    def _failures(self, seen: Seen) -> int:
        m, low, high = self._m, self._reach.low_rad, self._reach.high_rad
        found = 0
        for index, flag in ((0, "AT_YAW_LIMIT"), (1, "AT_PITCH_LIMIT")):
            at = seen.position_rad[index]
            if at < low[index] + _AT_LIMIT_RAD or at > high[index] - _AT_LIMIT_RAD:
                found |= getattr(m, f"GIMBAL_DEVICE_ERROR_FLAGS_{flag}")
        # the drive's own word tells more than the host's "drive fault"
        for word in {seen.drive_fault if seen.guard == "drive_fault" else seen.guard, seen.drive_fault} - {"", "none"}:
            found |= self._failure(word)
        if not seen.linked:
            found |= m.GIMBAL_DEVICE_ERROR_FLAGS_COMMS_ERROR
        return int(found)

    def _failure(self, word: str) -> int:
        m = self._m
        kinds = (
            (_POWER, m.GIMBAL_DEVICE_ERROR_FLAGS_POWER_ERROR),
            (_ENCODERS, m.GIMBAL_DEVICE_ERROR_FLAGS_ENCODER_ERROR),
            (_SOFTWARE, m.GIMBAL_DEVICE_ERROR_FLAGS_SOFTWARE_ERROR),
            (_COMMUNICATION, m.GIMBAL_DEVICE_ERROR_FLAGS_COMMS_ERROR),
        )
        return next((flag for words, flag in kinds if word in words), m.GIMBAL_DEVICE_ERROR_FLAGS_MOTOR_ERROR)
