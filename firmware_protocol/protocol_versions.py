"""The wire's versions as tools read them: logs of earlier versions stay readable, a running host and antenna speak the
newest only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from firmware_protocol.errors import BadInputError
from firmware_protocol.layout import CRC_INITIAL, CRC_TABLE
from firmware_protocol.schema import BY_NAME, CRC_BITS, MESSAGES, PROTOCOL_VERSION, Field, Message
from firmware_protocol.words import crc_table

#: CRC-12/DECT, which version 1 took over data id, bytes 0 to 5 and the counter
_DECT = 0x80F


@dataclass(frozen=True)
class Protocol:
    """One version: its messages, and per message (by data id) where its CRC starts; `crc_table` as `words.crc12` wants
    it.
    """

    version: int
    messages: tuple[Message, ...]
    crc_table: Sequence[int]
    crc_initial: dict[str, int]

    @cached_property
    def by_name(self) -> dict[str, Message]:
        """Messages by name."""
        return {message.name: message for message in self.messages}

    @cached_property
    def by_can_id(self) -> dict[int, Message]:
        """Messages by identifier."""
        return {message.can_id: message for message in self.messages}


def _first_version() -> Protocol:
    angles = tuple(Field(name, 16, True, 1e-4, "rad", text=f"base {name}") for name in ("roll", "pitch", "yaw"))
    changed = {
        "drive_control": BY_NAME["drive_control"].fields[:4],
        "deadman_config": (BY_NAME["deadman_config"].fields[0], replace(BY_NAME["deadman_config"].fields[1], bits=2)),
        "motor_status_outer": BY_NAME["motor_status_outer"].fields[:3],
        "motor_status_inner": BY_NAME["motor_status_inner"].fields[:3],
        "base_attitude": angles,
    }
    messages = tuple(
        replace(message, fields=changed.get(message.name, message.fields))
        for message in MESSAGES
        if message.can_id <= 0x180
    )
    table = crc_table(_DECT, CRC_BITS, 8)
    return Protocol(1, messages, table[256:], {message.name: table[message.data_id] for message in messages})


CURRENT = Protocol(
    PROTOCOL_VERSION,
    MESSAGES,
    CRC_TABLE,
    {message.name: initial for message, initial in zip(MESSAGES, CRC_INITIAL, strict=True)},
)
_PROTOCOLS = {1: _first_version(), CURRENT.version: CURRENT}


def protocol(version: int, where: str) -> Protocol:
    """A version's definition; BadInputError, naming `where` it was asked for, when there is none."""
    if version not in _PROTOCOLS:
        known = " or ".join(map(str, _PROTOCOLS))
        raise BadInputError(where, f"is {version}", f"{known}: this version of gimbal-hil reads no other")
    return _PROTOCOLS[version]
