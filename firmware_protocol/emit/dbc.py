"""Emits `gimbal.dbc`: the messages for CAN tools (cantools, SavvyCAN, and others)."""

from __future__ import annotations

from firmware_protocol.schema import (
    COUNTER_BITS,
    COUNTER_START,
    CRC_BITS,
    CRC_START,
    MESSAGES,
    PAYLOAD_SIZE,
    PROTOCOL_VERSION,
    REFERENCE_RATE_HZ,
    Direction,
    Field,
    Message,
)

_NODE = {Direction.HOST_TO_DEVICE: "Host", Direction.DEVICE_TO_HOST: "Antenna"}

_SECTIONS = """NS_ :
\tNS_DESC_
\tCM_
\tBA_DEF_
\tBA_
\tVAL_
\tBA_DEF_DEF_

BS_:

BU_: Host Antenna
"""

_COUNTER = Field("alive_counter", COUNTER_BITS, text="one more with every frame of this message, modulo 16")
_CRC = Field("crc", CRC_BITS, text="CRC-12 (polynomial 0x75D) over data id, low half of byte 6 and bytes 0 to 5")


def emit_dbc() -> str:
    """Text of the file."""
    parts = [f'VERSION "{PROTOCOL_VERSION}"\n', _SECTIONS]
    parts += [_message(message) for message in MESSAGES]
    parts += [
        'CM_ "Two-axis gimballed antenna: torque commands, feedback and drive states. '
        'Emitted by gimbal-hil protocol --emit dbc.";'
    ]
    parts += [line for message in MESSAGES for line in _comments(message)]
    parts += [
        'BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;',
        'BA_DEF_ BO_ "GenMsgSendType" ENUM "Cyclic","Event";',
        'BA_DEF_ BO_ "DataId" INT 0 255;',
        'BA_DEF_DEF_ "GenMsgCycleTime" 0;',
        'BA_DEF_DEF_ "GenMsgSendType" "Cyclic";',
        'BA_DEF_DEF_ "DataId" 0;',
    ]
    parts += [line for message in MESSAGES for line in _attributes(message)]
    parts += [_values(message, field) for message in MESSAGES for field in message.fields if field.enum is not None]
    return "\n".join(parts) + "\n"


def signals(message: Message) -> list[tuple[int, Field]]:
    """First bit and definition of all signals of a frame, counter and CRC included."""
    placed = [(message.start(field.name), field) for field in message.fields]
    return [*placed, (COUNTER_START, _COUNTER), (CRC_START, _CRC)]


def _message(message: Message) -> str:
    lines = [f"BO_ {message.can_id} {message.name}: {PAYLOAD_SIZE} {_NODE[message.direction]}"]
    receiver = _NODE[Direction(1 - message.direction)]
    for start, field in signals(message):
        sign = "-" if field.signed else "+"
        low, high = field.raw_low * field.step, field.raw_high * field.step
        lines.append(
            f" SG_ {field.name} : {start}|{field.bits}@1{sign} ({_number(field.step)},0)"
            f' [{_number(low)}|{_number(high)}] "{field.unit}" {receiver}'
        )
    return "\n".join(lines) + "\n"


def _comments(message: Message) -> list[str]:
    lines = [f'CM_ BO_ {message.can_id} "{message.text}";']
    return lines + [f'CM_ SG_ {message.can_id} {field.name} "{field_text(field)}";' for _, field in signals(message)]


def _attributes(message: Message) -> list[str]:
    cycle_ms = round(message.period_ticks * 1000 / REFERENCE_RATE_HZ)
    return [
        f'BA_ "GenMsgCycleTime" BO_ {message.can_id} {cycle_ms};',
        f'BA_ "GenMsgSendType" BO_ {message.can_id} {0 if message.period_ticks else 1};',
        f'BA_ "DataId" BO_ {message.can_id} {message.data_id};',
    ]


def _values(message: Message, field: Field) -> str:
    if field.enum is None:
        return ""
    members = sorted((int(member.value), member.name) for member in field.enum)
    named = " ".join(f'{value} "{name}"' for value, name in reversed(members))
    return f"VAL_ {message.can_id} {field.name} {named} ;"


def field_text(field: Field) -> str:
    """What a field means, and where its step is not the last word, what multiplies it."""
    return f"{field.text}; its step times two to `identity_unit.{field.exponent}`" if field.exponent else field.text


def _number(value: float) -> str:
    return str(int(value)) if value == int(value) else repr(value)
