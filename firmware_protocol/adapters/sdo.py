"""Expedited SDO transfers (CiA 301): one object of up to four bytes, read or written, and what the answer says."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from firmware_protocol.links import CanFrame

SDO_ANSWER, SDO_REQUEST = 0x580, 0x600
_WRITE = {1: 0x2F, 2: 0x2B, 3: 0x27, 4: 0x23}
_READ, _WROTE, _TOLD, _ABORTED = 0x40, 0x60, 0x40, 0x80
_FORM = struct.Struct("<BHBI")


@dataclass(frozen=True)
class SdoAnswer:
    """Of a node: a value that was read, None for a write that was taken or refused; `abort` 0 where nothing failed."""

    index: int
    sub: int
    value: int | None = None
    abort: int = 0

    @property
    def refusal(self) -> str:
        """In words, empty where nothing was refused."""
        if not self.abort:
            return ""
        reason = ABORTS.get(self.abort)
        return f"object 0x{self.index:04X} refused, abort code 0x{self.abort:08X}" + (f" ({reason})" if reason else "")


#: abort codes of CiA 301 that a drive answers a set-up with
ABORTS = {
    0x0503_0000: "toggle bit",
    0x0504_0000: "timed out",
    0x0504_0001: "unknown command",
    0x0601_0000: "access not supported",
    0x0601_0001: "write only",
    0x0601_0002: "read only",
    0x0602_0000: "no such object",
    0x0604_0041: "object cannot be mapped",
    0x0604_0042: "mapping too long",
    0x0606_0000: "hardware error",
    0x0607_0010: "wrong length",
    0x0609_0011: "no such sub-index",
    0x0609_0030: "value out of range",
    0x0800_0000: "general error",
    0x0800_0020: "cannot be stored",
    0x0800_0021: "local control",
    0x0800_0022: "not in this state of the device",
}


def written(node: int, index: int, sub: int, size: int, value: int) -> CanFrame:
    """The request to write a value of 1 to 4 bytes."""
    return CanFrame(SDO_REQUEST + node, _FORM.pack(_WRITE[size], index, sub, value))


def asked(node: int, index: int, sub: int) -> CanFrame:
    """The request to read one."""
    return CanFrame(SDO_REQUEST + node, _FORM.pack(_READ, index, sub, 0))


def answer_of(data: bytes) -> SdoAnswer | None:
    """What an answer's eight bytes say; None for one that is no expedited transfer."""
    if len(data) != _FORM.size:
        return None
    command, index, sub, value = _FORM.unpack(data)
    if command == _ABORTED:
        return SdoAnswer(index, sub, abort=value or 0x0800_0000)
    if command == _WROTE:
        return SdoAnswer(index, sub)
    if command & 0xE3 == _TOLD | 0x03:
        return SdoAnswer(index, sub, value & (1 << 8 * (4 - (command >> 2 & 3))) - 1)
    return SdoAnswer(index, sub, value) if command == _TOLD | 0x02 else None
