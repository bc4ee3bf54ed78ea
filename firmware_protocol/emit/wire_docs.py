"""Emits `docs/reference/wire.md`: the wire for people, numbers computed from the same source."""

from __future__ import annotations

from enum import Enum
from textwrap import wrap

from firmware_protocol.bus_load import LOAD_LIMIT, bus_load, frame_bits, highest_rate_hz, serial_load
from firmware_protocol.codec import pack_raw
from firmware_protocol.emit.dbc import field_text
from firmware_protocol.enumerations import ENUMERATIONS
from firmware_protocol.lockstep import edge
from firmware_protocol.receiver import DEGRADED_PERIODS, LATE_STEP, LOST_PERIODS
from firmware_protocol.schema import (
    BY_NAME,
    CRC_CHECK,
    CRC_POLYNOMIAL,
    EDGE_BITS,
    EDGE_CAN_ID,
    MESSAGES,
    PROTOCOL_VERSION,
    REFERENCE_RATE_HZ,
    Direction,
    Field,
    Message,
)
from firmware_protocol.stream import PACKET_FRAMES, PACKET_LIMIT, encode_packets

_EXAMPLE = ("set_point", (8000, -4000, 7, 1, 1), 3)


def emit_docs() -> str:
    """Text of the page."""
    return "\n".join(
        [_introduction(), _messages(), _enumerations(), _seal(), _receiver(), _serial(), _lockstep(), _load()]
    )


def _introduction() -> str:
    return f"""# The wire, version {PROTOCOL_VERSION}

Emitted from `firmware_protocol/schema.py` by `gimbal-hil protocol --emit docs`; do not edit. The same source gives
`gimbal.dbc` (for cantools, SavvyCAN and others), `gimbal_protocol.h` (C99, for firmware) and both codecs.

Every frame is a classic CAN frame with an 11-bit identifier and eight bytes, on every transport. The payload is one
little-endian 64-bit word: fields in bits 0 to 47 from bit 0 on in the order below, alive counter in bits 48 to 51, CRC
in bits 52 to 63. Numbers on the wire are integers, signed ones in two's complement; physical value = integer times
step. A field beyond its bounds makes the whole frame bad. A sender limits a number to the bound, so that nothing wraps
round.

An antenna says who it is in `identity` and `identity_unit`: once a second, and in the tick in which
`drive_control.identify` asks. A host switches no torque on before it has heard both. Run folders of version 1 are still
read (`firmware_protocol/protocol_versions.py`).
"""


def _messages() -> str:
    return (
        "## Messages\n\nRates are those at a tick of "
        + f"{REFERENCE_RATE_HZ:g} Hz.\n\n"
        + "\n".join(map(_message, MESSAGES))
    )


def _message(message: Message) -> str:
    arrow = "host to device" if message.direction is Direction.HOST_TO_DEVICE else "device to host"
    rate = f"{REFERENCE_RATE_HZ / message.period_ticks:g} Hz" if message.period_ticks else "on an event"
    title = f"### `{message.name}` 0x{message.can_id:03X}, {arrow}, {rate}, data id 0x{message.data_id:02X}"
    rows = _rows(message)
    head = f"{title}\n\n{_sentence(message.text)}"
    other = message.name.replace("inner", "outer")
    if other != message.name and [row.replace("outer", "inner") for row in _rows(BY_NAME[other])] == rows:
        return f"{head} Fields as in `{other}`.\n"
    return "\n".join(
        [f"{head}\n", "| field | bits | type | step | range | meaning |", "|---|---|---|---|---|---|", *rows, ""]
    )


def _rows(message: Message) -> list[str]:
    return [_row(message, field) for field in message.fields]


def _row(message: Message, field: Field) -> str:
    start = message.start(field.name)
    end = start + field.bits - 1
    bits = f"{start}..{end}" if end > start else f"{start}"
    if field.enum is not None:
        kind, step, bounds = field.enum.__name__, "", ""
    elif field.is_flag:
        kind, step, bounds = "flag", "", ""
    else:
        kind = f"{'int' if field.signed else 'uint'}{field.bits}"
        step = f"{field.step:.7g} {field.unit}" if field.unit else ""
        bounds = f"{field.raw_low * field.step:.6g} .. {field.raw_high * field.step:.6g}"
    return f"| `{field.name}` | {bits} | {kind} | {step} | {bounds} | {field_text(field)} |"


def _enumerations() -> str:
    guards = "What raises each `FaultCode`, and what the antenna then does: [guards](guards.md#drive).\n\n"
    return "## Enumerations\n\n" + guards + "\n".join(map(_enumeration, ENUMERATIONS))


def _enumeration(enumeration: type[Enum]) -> str:
    text = _sentence(" ".join((enumeration.__doc__ or "").split()))
    # a value stays on the line of its name
    members = ", ".join(f"{int(member.value)}\0`{member.name}`" for member in enumeration)
    return "\n".join(wrap(f"**{enumeration.__name__}**: {text} {members}.", 120)).replace("\0", " ") + "\n"


def _seal() -> str:
    name, raw, counter = _EXAMPLE
    payload = pack_raw(BY_NAME[name], raw, counter)
    values = ", ".join(f"{field.name} {number}" for field, number in zip(BY_NAME[name].fields, raw, strict=True))
    return f"""## CRC and alive counter

CRC-12: width 12, polynomial 0x{CRC_POLYNOMIAL:03X} (0xBAE as Koopman writes it), start 0, nothing reflected, nothing
inverted; of the nine characters `123456789` it is 0x{CRC_CHECK:03X}. It runs over eight bytes: the data id, the counter
(payload byte 6 with its upper half zero), payload bytes 0 to 5. The data id is not sent: it makes a frame under another
message's identifier fail. It detects every error of up to four bits in a payload, and every burst of up to twelve
within the fields. Of all others about one in 4096 passes; the CRC of CAN or of the serial packet has to miss it too.
`docs/measurements/residual-errors.md` has the remaining rates for each transport.

The counter goes up by one with every frame of its message, modulo 16.

Example in raw integers: `{name}` with
{values}, counter {counter}:
`{payload.hex(" ")}`.
"""


def _receiver() -> str:
    return f"""## What a receiver does

A value changes only on a frame whose identifier, length, CRC, bounds and counter are right; everything else is counted
and dropped. A repeated counter is a duplicate. A jump counts the frames that are missing; a step of {LATE_STEP} to 15
is a late frame, which is dropped. Each message is *ok*, *degraded* (over {DEGRADED_PERIODS} periods without a good
frame, or about one frame in five bad or missing) or *lost* (over {LOST_PERIODS} periods). For a lost message the next
good frame is accepted with any counter. A message that is sent on an event is never lost by silence.
"""


def _serial() -> str:
    name, raw, counter = _EXAMPLE
    block = BY_NAME[name].can_id.to_bytes(2, "little") + pack_raw(BY_NAME[name], raw, counter)
    return f"""## Serial lines

A block is a row of ten-byte records: identifier (little-endian, two bytes), payload (eight). A packet is COBS(block,
CRC-16 of the block with its most significant byte first) and a zero byte; the CRC is CRC-16/CCITT-FALSE (0x29B1 of
`123456789`). At most {PACKET_FRAMES} frames a packet, {PACKET_LIMIT} bytes before the zero. A receiver drops a packet
that is not valid and begins again after the next zero. The frame above as a packet:
`{encode_packets(block).hex(" ")}`.

Over slcan a record is the line `tiiil<data>`; over a Unix socket (SOCK_SEQPACKET) a packet is a block as it is.
"""


def _lockstep() -> str:
    return f"""## Lockstep

A simulated antenna may get its clock from the host (`gimbal-hil plant --lockstep`, `gimbal-hil daemon --lockstep`). The
host then ends the frames of a tick with an edge, identifier 0x{EDGE_CAN_ID:03X}, data id 0x{EDGE_CAN_ID >> 4:02X}: bits
0 to {EDGE_BITS - 1} are its number, up by one with every tick, the alive counter is the number modulo 16, CRC as
everywhere. The antenna takes the frames before the edge, advances by one tick, and ends its answer with an edge of the
same number. Between edges its time does not advance. Number 0 begins: it is answered without a tick; after the last
number comes 1. Edge 1 is the record `{edge(1).hex(" ")}`. An antenna with a clock of its own
drops edges as frames of an unknown identifier.
"""


def _load() -> str:
    rows = ["| bitrate | tick rate | load |", "|---|---|---|"]
    for bitrate, rate in ((1_000_000, 1000.0), (1_000_000, 500.0), (500_000, 500.0), (250_000, 200.0)):
        rows.append(f"| {bitrate // 1000} kbit/s | {rate:g} Hz | {bus_load(rate, bitrate):.1%} |")
    table = "\n".join(rows)
    return f"""## Load

Worst case on CAN: {frame_bits()} bit times a frame, stuff bits and interframe space included (Davis, Burns, Bril,
Lukkien 2007). All messages together, both directions, event messages as if one came every 100 ticks:

{table}

A rate that takes more than {LOAD_LIMIT:.0%} of the bus is refused: at most {int(highest_rate_hz(1_000_000))} Hz at 1
Mbit/s. At 1 kHz the load of a serial line at 921600 bit/s is {serial_load(1000.0, 921_600):.1%} in its busier
direction.
"""


def _sentence(text: str) -> str:
    text = text.rstrip(".")
    return text[:1].upper() + text[1:] + "."
