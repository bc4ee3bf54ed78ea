"""Object dictionary of a simulated CiA 402 drive: what it has, of which size, and what it refuses."""

from __future__ import annotations

import math
import struct

_WRITE, _READ = {0x2F: 1, 0x2B: 2, 0x27: 3, 0x23: 4}, 0x40
_WROTE, _ABORT = 0x60, 0x80
_NO_OBJECT, _NO_SUB_INDEX, _READ_ONLY = 0x0602_0000, 0x0609_0011, 0x0601_0002
_WRONG_LENGTH, _NOT_IN_THIS_STATE, _NO_SUCH_COMMAND = 0x0607_0010, 0x0800_0022, 0x0504_0001
_OFF = 0x8000_0000
#: parameters of a PDO -> where its mapping stands
_MAPPINGS = {0x1400: 0x1600, 0x1401: 0x1601, 0x1800: 0x1A00, 0x1801: 0x1A01}
#: (index, sub-index) -> bytes, value at power-up; a PDO begins switched off
_SIZES: dict[tuple[int, int], tuple[int, int]] = {
    (0x1016, 1): (4, 0),
    (0x1029, 1): (1, 0),
    (0x6007, 0): (2, 1),
    (0x605A, 0): (2, 2),
    (0x605E, 0): (2, 2),
    (0x6060, 0): (1, 0),
    (0x6085, 0): (4, 0),
    **{(parameters, 1): (4, _OFF) for parameters in _MAPPINGS},
    **{(parameters, 2): (1, 255) for parameters in _MAPPINGS},
    **{(mapping, 0): (1, 0) for mapping in _MAPPINGS.values()},
    **{(mapping, place): (4, 0) for mapping in _MAPPINGS.values() for place in range(1, 5)},
}
#: what can only be read
_TOLD = {(0x1000, 0): 4, (0x1001, 0): 1, (0x603F, 0): 2, (0x6041, 0): 2, (0x6076, 0): 4}
#: how fast a quick stop slows down, rad/s^2 at the shaft
_QUICK_RAD_S2 = 100.0


class Dictionary:
    """Values by (index, sub-index); `answer` is the SDO server."""

    def __init__(self, node: int, counts: float, watches: bool) -> None:
        self._node, self.watches = node, watches
        self._values = {place: value for place, (_, value) in _SIZES.items()}
        self._values[0x6085, 0] = round(_QUICK_RAD_S2 * counts / (2.0 * math.pi))
        #: objects that can only be read
        self.now = dict.fromkeys(_TOLD, 0) | {(0x1000, 0): 0x0002_0192, (0x6076, 0): 1000}

    def __getitem__(self, place: tuple[int, int]) -> int:
        return self._values.get(place, 0)

    def __setitem__(self, place: tuple[int, int], value: int) -> None:
        self._values[place] = value

    def answer(self, data: bytes) -> bytes:
        """The SDO server's answer to an expedited request of eight bytes."""
        command, (index, sub) = data[0], struct.unpack_from("<HB", data, 1)
        if command == _READ:
            return self._read(index, sub)
        if command not in _WRITE:
            return struct.pack("<BHBI", _ABORT, index, sub, _NO_SUCH_COMMAND)
        size = _WRITE[command]
        value = int.from_bytes(data[4 : 4 + size], "little")
        refused = self._refusal(index, sub, size, value)
        if refused:
            return struct.pack("<BHBI", _ABORT, index, sub, refused)
        self._values[index, sub] = value
        return struct.pack("<BHBI", _WROTE, index, sub, 0)

    def _read(self, index: int, sub: int) -> bytes:
        place = index, sub
        if place not in _TOLD and (place not in _SIZES or not self._has(index)):
            return struct.pack("<BHBI", _ABORT, index, sub, self._absent(index))
        size = _TOLD[place] if place in _TOLD else _SIZES[place][0]
        value = self.now[place] if place in _TOLD else self._values[place]
        return struct.pack("<BHBI", 0x43 | (4 - size) << 2, index, sub, value)

    def _refusal(self, index: int, sub: int, size: int, value: int) -> int:
        """The abort code of a write, nothing where it is taken."""
        if (index, sub) in _TOLD:
            return _READ_ONLY
        if (index, sub) not in _SIZES or not self._has(index):
            return self._absent(index)
        if size != _SIZES[index, sub][0]:
            return _WRONG_LENGTH
        for parameters, mapping in _MAPPINGS.items():
            off = bool(self._values[parameters, 1] & _OFF)
            # a mapping is changed of a PDO that is switched off, an entry of one that counts none
            if index == mapping and (not off or (sub and self._values[mapping, 0])):
                return _NOT_IN_THIS_STATE
            if (index, sub) == (parameters, 1) and not off and not value & _OFF:
                return _NOT_IN_THIS_STATE
        return 0

    def _has(self, index: int) -> bool:
        return self.watches or index != 0x1016

    def _absent(self, index: int) -> int:
        known = any(index == there for there, _ in (*_SIZES, *_TOLD)) and self._has(index)
        return _NO_SUB_INDEX if known else _NO_OBJECT
