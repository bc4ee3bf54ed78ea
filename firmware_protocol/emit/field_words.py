"""Emits `firmware_protocol/field_words.py`: mail slots to field word and back, with every number in place."""

from __future__ import annotations

from firmware_protocol.schema import INDEX, MESSAGES, Field, Message, offset

_HEADING = '''"""Field words from mail slots and back, every shift and bound a literal.

Emitted from `schema` by `gimbal-hil protocol --emit field_words`; do not edit. One expression per field, because each
call of a small compiled function with other literals would be compiled anew; every branch returns, because then only
one is computed. The table-driven `codec` reads the schema independently, and the tests hold this one against it.
"""

from __future__ import annotations

from firmware_protocol.leaves import leaf
from firmware_protocol.words import Slots
'''


_PACK = '''

@leaf
def pack(message: int, mail: Slots) -> int:
    """Field word of the message with that index; values held at their bounds."""
    word = 0
'''

_UNPACK = '''

@leaf
def unpack(message: int, word: int, mail: Slots) -> bool:
    """Field word into the mail; False, and nothing written, when a field is out of bounds."""
'''


def emit_field_words() -> str:
    """Text of the module."""
    return "".join(
        [
            _HEADING,
            _PACK,
            *map(_pack, MESSAGES),
            "    return word\n",
            _UNPACK,
            *map(_unpack, MESSAGES),
            "    return False\n",
        ]
    )


def _pack(message: Message) -> str:
    slot = offset(message.name) + 1
    lines = [f"    if message == {INDEX[message.name]}:  # {message.name}"]
    for place, field in enumerate(message.fields):
        held = f"min(max(mail[{slot + place}], {field.raw_low}), {field.raw_high})"
        lines.append(f"        word |= ({held} & {_mask(field)}) << {message.start(field.name)}")
    return "\n".join(lines) + "\n        return word\n"


def _unpack(message: Message) -> str:
    slot = offset(message.name) + 1
    lines = [f"    if message == {INDEX[message.name]}:  # {message.name}"]
    for field in message.fields:
        lines.append(f"        {field.name} = (word >> {message.start(field.name)}) & {_mask(field)}")
        if field.signed:
            lines.append(f"        {field.name} -= ({field.name} & 0x{1 << (field.bits - 1):X}) << 1")
    outside = [bound for field in message.fields for bound in _bounds(field)]
    if outside:
        lines += [f"        if {' or '.join(outside)}:", "            return False"]
    lines += [f"        mail[{slot + place}] = {field.name}" for place, field in enumerate(message.fields)]
    return "\n".join(lines) + "\n        return True\n"


def _mask(field: Field) -> str:
    return f"0x{(1 << field.bits) - 1:X}"


def _bounds(field: Field) -> list[str]:
    least, greatest = (-(1 << (field.bits - 1)) if field.signed else 0), (1 << (field.bits - int(field.signed))) - 1
    below = [f"{field.name} < {field.raw_low}"] if field.raw_low > least else []
    return below + ([f"{field.name} > {field.raw_high}"] if field.raw_high < greatest else [])
