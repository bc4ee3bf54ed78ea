"""Emits `gimbal_protocol.h`: the wire for firmware, C99, no allocation, no dependency but <stdint.h>, <stdbool.h>."""

from __future__ import annotations

from enum import Enum

from firmware_protocol import receiver
from firmware_protocol.emit.mail import screaming
from firmware_protocol.enumerations import ENUMERATIONS
from firmware_protocol.schema import (
    CRC_CHECK,
    CRC_POLYNOMIAL,
    EDGE_CAN_ID,
    MESSAGES,
    PROTOCOL_VERSION,
    Direction,
    Field,
    Message,
)

_HEAD = """/* The wire of the gimballed antenna, for firmware. C99.
 *
 * Emitted from the schema by `gimbal-hil protocol --emit c`; do not edit.
 *
 * A payload is eight bytes: fields in bits 0..47 of a little-endian word, alive counter in bits 48..51, CRC in bits
 * 52..63. Structures hold raw integers; physical value = raw * GIMBAL_..._STEP. Packing holds a number at its bounds.
 */
#ifndef GIMBAL_PROTOCOL_H
#define GIMBAL_PROTOCOL_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define GIMBAL_PAYLOAD_SIZE 8
#define GIMBAL_PROTOCOL_VERSION %(version)du

/* What a receiver does (docs/reference/wire.md): the counter of a message is forgotten after so many of its periods of
   silence, of a message sent on an event after so many ticks; a counter that many steps ahead is a late frame. */
#define GIMBAL_LOST_PERIODS %(lost_periods)du
#define GIMBAL_EVENT_MEMORY_TICKS %(event_memory)du
#define GIMBAL_LATE_STEP %(late_step)du
#define GIMBAL_UNKNOWN_COUNTER (%(unknown_counter)d)

/* The edge of a tick in lockstep over a link, for simulated boards (docs/reference/wire.md); a device with a clock
   drops it. */
#define GIMBAL_EDGE_ID 0x%(edge_id)03Xu
#define GIMBAL_EDGE_DATA_ID 0x%(edge_data_id)02Xu
"""

_ARITHMETIC = """
/* CRC-12: polynomial 0x%(polynomial)03X, start 0; of "123456789" it is 0x%(check)03X. */
static inline uint16_t gimbal_crc12_byte(uint16_t crc, uint8_t octet)
{
    crc ^= (uint16_t)((uint16_t)octet << 4);
    for (int bit = 0; bit < 8; ++bit)
        crc = (uint16_t)((crc & 0x800u) ? (uint16_t)(crc << 1) ^ 0x%(polynomial)03Xu : (uint16_t)(crc << 1));
    return crc & 0xFFFu;
}

/* CRC of a payload: data id, low half of byte 6, bytes 0..5. */
static inline uint16_t gimbal_crc12(uint8_t data_id, const uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    uint16_t crc = gimbal_crc12_byte(gimbal_crc12_byte(0, data_id), (uint8_t)(payload[6] & 0x0Fu));
    for (int place = 0; place < 6; ++place)
        crc = gimbal_crc12_byte(crc, payload[place]);
    return crc;
}

/* Puts fields, counter and CRC into a payload. */
static inline void gimbal_seal(uint8_t data_id, uint64_t fields, uint8_t counter, uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    for (int place = 0; place < 6; ++place)
        payload[place] = (uint8_t)(fields >> (8 * place));
    payload[6] = (uint8_t)(counter & 0x0Fu);
    const uint16_t crc = gimbal_crc12(data_id, payload);
    payload[6] = (uint8_t)(payload[6] | (uint8_t)((crc & 0x0Fu) << 4));
    payload[7] = (uint8_t)(crc >> 4);
}

/* Takes the fields out of a payload; false when its CRC is wrong. */
static inline bool gimbal_unseal(uint8_t data_id, const uint8_t payload[GIMBAL_PAYLOAD_SIZE], uint64_t *fields)
{
    if (gimbal_crc12(data_id, payload) != (uint16_t)((payload[6] >> 4) | (payload[7] << 4)))
        return false;
    *fields = 0;
    for (int place = 0; place < 6; ++place)
        *fields |= (uint64_t)payload[place] << (8 * place);
    return true;
}

/* Alive counter of a payload. */
static inline uint8_t gimbal_alive_counter(const uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    return payload[6] & 0x0Fu;
}

static inline int32_t gimbal_hold(int32_t raw, int32_t low, int32_t high)
{
    return raw < low ? low : raw > high ? high : raw;
}

static inline uint64_t gimbal_insert(uint64_t word, int start, int bits, int32_t raw)
{
    return word | (((uint64_t)(int64_t)raw & ((UINT64_C(1) << bits) - 1u)) << start);
}

static inline int32_t gimbal_extract(uint64_t word, int start, int bits, bool is_signed)
{
    const int64_t raw = (int64_t)((word >> start) & ((UINT64_C(1) << bits) - 1u));
    return (int32_t)(is_signed && (raw >> (bits - 1)) ? raw - ((int64_t)1 << bits) : raw);
}
"""

_FOOT = """
#ifdef __cplusplus
}
#endif

#endif /* GIMBAL_PROTOCOL_H */
"""


def emit_c() -> str:
    """Text of the header."""
    arithmetic = _ARITHMETIC % {"polynomial": CRC_POLYNOMIAL, "check": CRC_CHECK}
    constants = {
        "version": PROTOCOL_VERSION,
        "lost_periods": receiver.LOST_PERIODS,
        "event_memory": receiver.EVENT_MEMORY_TICKS,
        "late_step": receiver.LATE_STEP,
        "unknown_counter": receiver.UNKNOWN_COUNTER,
        "edge_id": EDGE_CAN_ID,
        "edge_data_id": EDGE_CAN_ID >> 4,
    }
    parts = [_HEAD % constants, *map(_enumeration, ENUMERATIONS), arithmetic]
    return "".join([*parts, *map(_message, MESSAGES), _FOOT])


def _enumeration(enumeration: type[Enum]) -> str:
    name = screaming(enumeration.__name__)
    members = ",\n".join(f"    GIMBAL_{name}_{member.name} = {int(member.value)}" for member in enumeration)
    return f"\n/* {(enumeration.__doc__ or '').strip()} */\nenum gimbal_{name.lower()} {{\n{members}\n}};\n"


def _message(message: Message) -> str:
    return "".join([_constants(message), _structure(message), _pack(message), _unpack(message)])


def _constants(message: Message) -> str:
    label = f"GIMBAL_{message.name.upper()}"
    arrow = "host to device" if message.direction is Direction.HOST_TO_DEVICE else "device to host"
    lines = [
        f"\n/* {message.name}, {arrow}:\n   {message.text} */",
        f"#define {label}_ID 0x{message.can_id:03X}u",
        f"#define {label}_DATA_ID 0x{message.data_id:02X}u",
        f"#define {label}_PERIOD_TICKS {message.period_ticks}u",
    ]
    lines += [
        f"#define {label}_{field.name.upper()}_STEP {field.step!r} /* {field.unit} */"
        for field in message.fields
        if field.is_physical
    ]
    for field in message.fields:
        if field.signed:
            name = f"{label}_{field.name.upper()}"
            lines += [f"#define {name}_LOW ({field.raw_low})", f"#define {name}_HIGH {field.raw_high}"]
    return "\n".join(lines) + "\n"


def _structure(message: Message) -> str:
    members = "\n".join(f"    {_type(field)} {field.name}; /* {field.text} */" for field in message.fields)
    return f"\ntypedef struct {{\n{members}\n}} gimbal_{message.name}_t;\n"


def _pack(message: Message) -> str:
    lines = [
        f"\nstatic inline void gimbal_{message.name}_pack(const gimbal_{message.name}_t *message, uint8_t counter,",
        "    uint8_t payload[GIMBAL_PAYLOAD_SIZE])",
        "{",
        "    uint64_t fields = 0;",
    ]
    for field in message.fields:
        raw = f"(int32_t)message->{field.name}"
        held = raw if _type(field) == "bool" else f"gimbal_hold({raw}, {field.raw_low}, {field.raw_high})"
        lines.append(f"    fields = gimbal_insert(fields, {message.start(field.name)}, {field.bits}, {held});")
    lines += [f"    gimbal_seal(GIMBAL_{message.name.upper()}_DATA_ID, fields, counter, payload);", "}\n"]
    return "\n".join(lines)


def _unpack(message: Message) -> str:
    lines = [
        "\n/* From fields whose CRC is right. False, and nothing written, when a field is out of its bounds. */",
        f"static inline bool gimbal_{message.name}_read(uint64_t fields, gimbal_{message.name}_t *message)",
        "{",
    ]
    for field in message.fields:
        sign = "true" if field.signed else "false"
        place = f"{message.start(field.name)}, {field.bits}, {sign}"
        lines.append(f"    const int32_t {field.name} = gimbal_extract(fields, {place});")
    # a field that its bits cannot bring out of its bounds is not asked
    lines += [
        f"    if ({field.name} < {field.raw_low} || {field.name} > {field.raw_high})\n        return false;"
        for field in message.fields
        if _may_be_out(field)
    ]
    lines += [f"    message->{field.name} = {_from_raw(field)};" for field in message.fields]
    lines += [
        "    return true;",
        "}",
        "\n/* False, and nothing written, when the CRC or a field is wrong. */",
        f"static inline bool gimbal_{message.name}_unpack(const uint8_t payload[GIMBAL_PAYLOAD_SIZE],",
        f"    gimbal_{message.name}_t *message)",
        "{",
        "    uint64_t fields;",
        f"    if (!gimbal_unseal(GIMBAL_{message.name.upper()}_DATA_ID, payload, &fields))",
        "        return false;",
        f"    return gimbal_{message.name}_read(fields, message);",
        "}\n",
    ]
    return "\n".join(lines)


def _may_be_out(field: Field) -> bool:
    least = -(1 << (field.bits - 1)) if field.signed else 0
    return field.raw_low > least or field.raw_high < least + (1 << field.bits) - 1


def _from_raw(field: Field) -> str:
    return f"{field.name} != 0" if field.is_flag else f"({_type(field)}){field.name}"


def _type(field: Field) -> str:
    if field.is_flag:
        return "bool"
    width = 8 if field.bits <= 8 else 16 if field.bits <= 16 else 32
    return f"{'int' if field.signed else 'uint'}{width}_t"
