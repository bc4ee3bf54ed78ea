"""Emits `firmware_protocol/messages.py`: one frozen dataclass per message, fields in physical units."""

from __future__ import annotations

from firmware_protocol.schema import MESSAGES, Field, Message

_HEADING = '''"""Every message as a frozen dataclass in physical units.

Emitted from `schema` by `gimbal-hil protocol --emit messages`; do not edit.
"""

from __future__ import annotations

from dataclasses import dataclass

from firmware_protocol.enumerations import (
{enumerations}
)
'''


def emit_messages() -> str:
    """Text of the module."""
    used = {field.enum.__name__ for message in MESSAGES for field in message.fields if field.enum is not None}
    parts = [_HEADING.format(enumerations="\n".join(f"    {name}," for name in sorted(used)))]
    parts += [_message(message) for message in MESSAGES]
    union = "\n    | ".join(message.class_name for message in MESSAGES)
    names = "\n".join(f'    "{message.name}": {message.class_name},' for message in MESSAGES)
    parts.append(f"\n\nAnyMessage = (\n    {union}\n)")
    parts.append(f"\nCLASSES: dict[str, type[AnyMessage]] = {{\n{names}\n}}\n")
    return "".join(parts)


def type_name(field: Field) -> str:
    """Python type of a field's value."""
    if field.enum is not None:
        return field.enum.__name__
    if field.is_flag:
        return "bool"
    return "float" if field.is_physical else "int"


def _message(message: Message) -> str:
    text = message.text[0].upper() + message.text[1:]
    lines = ["\n\n@dataclass(frozen=True, slots=True)", f"class {message.class_name}:", f'    """{text}."""\n']
    lines += [f"    #: {field.text}\n    {field.attribute}: {type_name(field)}" for field in message.fields]
    return "\n".join(lines) + "\n"
