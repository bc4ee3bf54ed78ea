"""Emits `firmware_protocol/mail.py`: the mail's layout as plain module constants that compiled code can name."""

from __future__ import annotations

from enum import Enum

from firmware_protocol.enumerations import ENUMERATIONS
from firmware_protocol.schema import INDEX, MAIL_SIZE, MESSAGES, Message, offset

_HEADING = '''"""Names and numbers of the mail, emitted from `schema` by `gimbal-hil protocol --emit mail`; do not edit.

For a message: `SET_POINT` is the slot of `fresh`, `SET_POINT_TORQUE_OUTER` that of a field, `SET_POINT_MESSAGE` its
index, `..._STEP` the physical size of a raw 1, `..._LOW` and `..._HIGH` the raw bounds. For an enumeration:
`DRIVE_STATE_FAULT` and so on.
"""

from __future__ import annotations
'''


def screaming(name: str) -> str:
    """`DriveState` as `DRIVE_STATE`."""
    return "".join("_" + letter if letter.isupper() and place else letter for place, letter in enumerate(name)).upper()


def emit_mail() -> str:
    """Text of the module."""
    parts = [_HEADING, f"MAIL_SIZE = {MAIL_SIZE}", f"MESSAGE_COUNT = {len(MESSAGES)}"]
    parts += [_message(message) for message in MESSAGES]
    parts += [_enumeration(enumeration) for enumeration in ENUMERATIONS]
    return "\n".join(parts) + "\n"


def _message(message: Message) -> str:
    name, slot = message.name.upper(), offset(message.name)
    lines = [f"\n# {message.name}: {message.text}", f"{name} = {slot}", f"{name}_MESSAGE = {INDEX[message.name]}"]
    for place, field in enumerate(message.fields, start=1):
        label = f"{name}_{field.name.upper()}"
        lines.append(f"{label} = {slot + place}")
        if field.is_physical:
            lines.append(f"{label}_STEP = {field.step!r}  # {field.unit}")
        if not field.is_flag:
            lines += [f"{label}_LOW = {field.raw_low}", f"{label}_HIGH = {field.raw_high}"]
    return "\n".join(lines)


def _enumeration(enumeration: type[Enum]) -> str:
    name = screaming(enumeration.__name__)
    return "\n".join(
        [f"\n# {enumeration.__name__}"] + [f"{name}_{member.name} = {int(member.value)}" for member in enumeration]
    )
