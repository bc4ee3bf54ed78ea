"""The wire's one definition: every message, field, unit and number. Codec, mail, DBC, C header and docs come from it.

Frame: a classic CAN frame of eight bytes, read as one little-endian 64-bit word.

    bits  0..47  fields, packed from bit 0 in the order given here
    bits 48..51  alive counter, +1 modulo 16 with every frame of that message
    bits 52..63  CRC-12 over the data id (one byte), then the counter (byte 6 with its upper half zero), then bytes 0..5

Mail: the same fields as raw integers in one int64 array, per message `[fresh, field 0, field 1, ...]`.
"""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass
from enum import IntEnum, IntFlag

from firmware_protocol.enumerations import (
    BrakeCommand,
    BrakeState,
    DriveRequest,
    DriveState,
    FaultCode,
    LimitFlags,
    StopReaction,
)

FIELD_BITS = 48
COUNTER_START, COUNTER_BITS = 48, 4
CRC_START, CRC_BITS = 52, 12
#: 0xBAE in Koopman's notation: finds all errors of up to four bits in up to 53 bits of data
#: (Koopman and Chakravarty, DSN 2004)
CRC_POLYNOMIAL = 0x75D
CRC_CHECK = 0x6DD  # of the nine bytes b"123456789"
#: first field of the identity; a log says which version its frames are, see `protocol_versions`
PROTOCOL_VERSION = 2

PAYLOAD_SIZE = 8
RECORD_SIZE = 10  # one frame in a block: little-endian identifier, payload
RECORD_FORMAT = "<H8s"

#: the edge of a tick in lockstep over a link (`firmware_protocol.lockstep`): no message, a device with a clock of its
#: own drops it; its number has so many bits
EDGE_CAN_ID, EDGE_BITS = 0x7F0, 32

#: the tick rate for which cycle times are quoted (DBC, docs)
REFERENCE_RATE_HZ = 1000.0


class Direction(IntEnum):
    """Who sends a message."""

    HOST_TO_DEVICE = 0
    DEVICE_TO_HOST = 1


#: how a unit ends a name that holds the physical value
UNIT_SUFFIX = {
    "": "",
    "N m": "_nm",
    "rad": "_rad",
    "rad/s": "_rad_s",
    "degC": "_degc",
    "V": "_v",
    "tick": "_ticks",
    "m/s^2": "_m_s2",
}


@dataclass(frozen=True)
class Field:
    """One number in a frame: physical value = raw integer times step.

    `low` and `high` are the physical bounds of a valid value; None means all that the bits can hold. A good frame has
    every field within them (an enumeration: one of its members).
    """

    name: str
    bits: int
    signed: bool = False
    step: float = 1.0
    unit: str = ""
    low: float | None = None
    high: float | None = None
    enum: type[IntEnum] | type[IntFlag] | None = None
    text: str = ""
    #: field of `identity_unit` with the exponent of two by which `step` is multiplied; none for a fixed step
    exponent: str = ""

    @property
    def raw_low(self) -> int:
        """Least valid raw integer."""
        least = -(1 << (self.bits - 1)) if self.signed else 0
        return least if self.low is None else max(least, math.ceil(self.low / self.step))

    @property
    def raw_high(self) -> int:
        """Greatest valid raw integer."""
        greatest = (1 << (self.bits - int(self.signed))) - 1
        if self.enum is not None and issubclass(self.enum, IntEnum):
            return min(greatest, int(max(self.enum)))
        return greatest if self.high is None else min(greatest, math.floor(self.high / self.step))

    @property
    def is_flag(self) -> bool:
        """Whether the field is one plain bit."""
        return self.bits == 1 and self.enum is None

    @property
    def is_physical(self) -> bool:
        """Whether the value is a measure (float), not a count, flag or enumeration."""
        return self.step != 1.0

    @property
    def attribute(self) -> str:
        """Name of the physical value, unit included, as in `torque_outer_nm`."""
        suffix = UNIT_SUFFIX[self.unit]
        return self.name if self.name.endswith(suffix) else self.name + suffix


@dataclass(frozen=True)
class Message:
    """One kind of frame. `period_ticks` is 0 for messages sent on an event only."""

    name: str
    can_id: int
    direction: Direction
    fields: tuple[Field, ...]
    period_ticks: int
    text: str

    @property
    def data_id(self) -> int:
        """The byte that starts the CRC, so that a frame under another identifier cannot pass."""
        return self.can_id >> 4

    def start(self, field_name: str) -> int:
        """First bit of a field in the 64-bit word."""
        bit = 0
        for field in self.fields:
            if field.name == field_name:
                return bit
            bit += field.bits
        raise KeyError(f"{self.name} has no field {field_name}")

    @property
    def class_name(self) -> str:
        """Name of the message's dataclass, as in `SetPoint`."""
        return "".join(word.capitalize() for word in self.name.split("_"))


#: of an axis whose torque exponent is 0; a unit of torque on the wire is this times two to the power that the identity
#: tells
TORQUE_STEP_NM = 0.125e-3
POSITION_STEP_RAD = 2.0 * math.pi / 2**22
RATE_STEP_RAD_S = 1e-5
#: of the base: 0.4 seconds of arc
ANGLE_STEP_RAD = 2e-6


def _torque(name: str, axis: str, text: str) -> Field:
    return Field(name, 18, True, TORQUE_STEP_NM, "N m", text=text, exponent=f"torque_exponent_{axis}")


def _feedback(axis: str, can_id: int) -> Message:
    fields = (
        Field("position", 26, True, POSITION_STEP_RAD, "rad", text="joint angle from the encoder, multi-turn"),
        Field("rate", 22, True, RATE_STEP_RAD_S, "rad/s", text="inertial rate about the axis from the gyro"),
    )
    return Message(
        f"feedback_{axis}",
        can_id,
        Direction.DEVICE_TO_HOST,
        fields,
        1,
        f"sensors of the {axis} axis, sampled at this tick",
    )


def _motor_status(axis: str, can_id: int) -> Message:
    fields = (
        _torque("torque", axis, "torque measured at the actuator, from motor current"),
        Field("temperature", 12, True, 0.1, "degC", text="winding temperature"),
        Field("supply", 12, False, 0.02, "V", text="supply voltage"),
        Field("brake", 2, enum=BrakeState, text="holding brake"),
        Field("shorted", 1, text="the drive has shorted this winding"),
    )
    return Message(f"motor_status_{axis}", can_id, Direction.DEVICE_TO_HOST, fields, 50, f"motor of the {axis} axis")


def _base(
    name: str, can_id: int, parts: tuple[str, ...], step: float, unit: str, period_ticks: int, text: str
) -> Message:
    fields = tuple(Field(part, 16, True, step, unit, text=f"base {part}") for part in parts)
    return Message(name, can_id, Direction.DEVICE_TO_HOST, fields, period_ticks, text)


def _angle(name: str) -> Field:
    return Field(name, 22, True, ANGLE_STEP_RAD, "rad", text=f"base {name}")


MESSAGES: tuple[Message, ...] = (
    Message(
        "drive_control",
        0x010,
        Direction.HOST_TO_DEVICE,
        (
            Field("request", 4, enum=DriveRequest, text="state wanted, as a CiA 402 command"),
            Field("fault_reset", 1, text="a rising edge leaves FAULT"),
            Field("quick_stop", 1, text="stop now, whatever the request"),
            Field("clear_travel", 1, text="allow torque that leads back from a travel limit"),
            Field("stop", 3, enum=StopReaction, text="how a quick stop stops"),
            Field("brake_outer", 2, enum=BrakeCommand, text="holding brake of the outer axis"),
            Field("brake_inner", 2, enum=BrakeCommand, text="holding brake of the inner axis"),
            Field("identify", 1, text="the antenna may say at once who it is"),
        ),
        100,
        "drive state requests, on change and repeated",
    ),
    Message(
        "set_point",
        0x020,
        Direction.HOST_TO_DEVICE,
        (
            _torque("torque_outer", "outer", "torque of the outer axis, held for one tick"),
            _torque("torque_inner", "inner", "torque of the inner axis, held for one tick"),
            Field("sequence", 10, text="number of the tick, modulo 1024"),
            Field("enable_outer", 1, text="the outer axis may apply torque"),
            Field("enable_inner", 1, text="the inner axis may apply torque"),
        ),
        1,
        "torque of both axes; a fresh one feeds the deadman",
    ),
    Message(
        "deadman_config",
        0x030,
        Direction.HOST_TO_DEVICE,
        (
            Field("window_ticks", 8, unit="tick", low=1, text="ticks without a fresh set-point before the reaction"),
            Field("reaction", 3, enum=StopReaction, text="what the drive does then"),
        ),
        0,
        "deadman, sent at connection",
    ),
    _feedback("outer", 0x110),
    _feedback("inner", 0x120),
    Message(
        "drive_status",
        0x130,
        Direction.DEVICE_TO_HOST,
        (
            Field("state", 4, enum=DriveState, text="drive state"),
            Field("fault", 6, enum=FaultCode, text="latched fault"),
            Field("last_sequence", 10, text="sequence of the set-point that acted before this sample"),
            Field("deadman_margin", 8, unit="tick", text="ticks left before the deadman reacts"),
            Field("limits", 8, enum=LimitFlags, text="limits that act now"),
            Field("tick", 12, text="the device's tick, modulo 4096"),
        ),
        1,
        "state of the drive; closes the feedback set of a tick",
    ),
    _motor_status("outer", 0x140),
    _motor_status("inner", 0x150),
    Message(
        "base_attitude",
        0x160,
        Direction.DEVICE_TO_HOST,
        (
            _angle("roll"),
            _angle("pitch"),
            Field("set", 4, text="lowest bits of the `valid_tick` of the base_heading that belongs to it"),
        ),
        10,
        "attitude of the base, R_eb = Rz(yaw) Ry(pitch) Rx(roll); base_heading in the next tick closes the set",
    ),
    _base("base_rate", 0x170, ("p", "q", "r"), 1e-4, "rad/s", 10, "angular rate of the base in base axes"),
    Message(
        "drive_event",
        0x180,
        Direction.DEVICE_TO_HOST,
        (
            Field("from_state", 4, enum=DriveState, text="state before"),
            Field("to_state", 4, enum=DriveState, text="state after"),
            Field("cause", 6, enum=FaultCode, text="why"),
            Field("detail", 8, text="more on the cause: axis, limit or request"),
            Field("tick", 12, text="the device's tick, modulo 4096"),
        ),
        0,
        "one transition of the drive state machine",
    ),
    Message(
        "base_heading",
        0x190,
        Direction.DEVICE_TO_HOST,
        (
            _angle("yaw"),
            Field("valid_tick", 12, text="the device's tick at which the attitude was true, modulo 4096"),
            Field("valid_fraction", 8, False, 2.0**-8, "tick", text="and how far into that tick"),
        ),
        10,
        "heading of the base, and when the attitude was true",
    ),
    _base(
        "base_acceleration",
        0x1A0,
        ("ax", "ay", "az"),
        2e-3,
        "m/s^2",
        20,
        "acceleration of the pivot in base axes, of the motion alone: gravity is not in it",
    ),
    Message(
        "identity",
        0x1B0,
        Direction.DEVICE_TO_HOST,
        (
            Field("protocol_version", 8, text="version of this protocol"),
            Field("name", 31, text="CRC-32 of the antenna's name in UTF-8, its lower 31 bits"),
            Field("has_brake_outer", 1, text="the outer axis has a holding brake"),
            Field("has_brake_inner", 1, text="the inner axis has a holding brake"),
        ),
        1000,
        "who the antenna is; at once when asked. Without it and identity_unit no torque is switched on",
    ),
    Message(
        "identity_unit",
        0x1C0,
        Direction.DEVICE_TO_HOST,
        (
            Field("serial_number", 31, text="serial number"),
            Field("torque_exponent_outer", 5, text="a torque of the outer axis counts its step times two to this"),
            Field("torque_exponent_inner", 5, text="a torque of the inner axis counts its step times two to this"),
        ),
        1000,
        "which antenna of its kind it is, and what a unit of its torques is",
    ),
)

BY_NAME: dict[str, Message] = {message.name: message for message in MESSAGES}
BY_CAN_ID: dict[int, Message] = {message.can_id: message for message in MESSAGES}
INDEX: dict[str, int] = {message.name: index for index, message in enumerate(MESSAGES)}


def offset(message_name: str) -> int:
    """Slot of a message's `fresh` in the mail array; its fields follow in schema order."""
    slot = 0
    for message in MESSAGES:
        if message.name == message_name:
            return slot
        slot += 1 + len(message.fields)
    raise KeyError(f"no message {message_name}")


def name_code(name: str) -> int:
    """What `identity` carries for an antenna's name."""
    return zlib.crc32(name.encode()) & 0x7FFFFFFF


MAIL_SIZE = sum(1 + len(message.fields) for message in MESSAGES)
