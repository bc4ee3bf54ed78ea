"""A moteus controller: register reads and writes in CAN-FD frames, after the controller reference of mjbots."""

from __future__ import annotations

import math
import struct

from firmware_protocol.adapters import CanFrame
from sim_backend.drives.axis import Shaft

_TURN = 2.0 * math.pi
_SIZES = {0: (1, "b"), 4: (2, "h"), 8: (4, "i"), 12: (4, "f")}
_STOPPED, _FAULT, _POSITION, _TIMEOUT = 0, 1, 10, 11
_LENGTHS = (*range(9), 12, 16, 20, 24, 32, 48, 64)


class SimulatedMoteus:
    """One controller with the id `number`."""

    def __init__(self, number: int) -> None:
        self.number, self.shaft = number, Shaft()
        self.mode, self.fault = _STOPPED, 0
        self._registers: dict[int, float] = {}
        self._left_s = 0.0

    @property
    def torque_nm(self) -> float:
        if self.mode != _POSITION:
            return 0.0
        # with gains scaled to anything but zero its own loops would work, which are not simulated
        assert self._registers.get(0x23, 1.0) == 0.0 and self._registers.get(0x24, 1.0) == 0.0
        return self._registers.get(0x22, 0.0)

    def hear(self, frame: CanFrame) -> list[CanFrame]:
        if not frame.fd or frame.identifier & 0x7F != self.number or frame.identifier & 0x80:
            return []
        answer = b""
        data, at = frame.data, 0
        while at < len(data):
            kind = data[at]
            at += 1
            if kind == 0x50:
                continue
            size, form = _SIZES[kind & 0x0C]
            count = kind & 3
            if count == 0:
                count, at = data[at], at + 1
            first, at = data[at], at + 1
            if kind & 0xF0 == 0x00:
                values = struct.unpack_from(f"<{count}{form}", data, at)
                at += count * size
                self._write(first, [float(value) for value in values])
            else:
                read = [self._read(first + place) for place in range(count)]
                head = bytes([0x20 | kind & 0x0C | (count if count < 4 else 0)])
                head += bytes([count] if count > 3 else []) + bytes([first])
                whole = [int(value) for value in read]
                answer += head + (
                    struct.pack(f"<{count}f", *read) if form == "f" else struct.pack(f"<{count}{form}", *whole)
                )
        if not frame.identifier & 0x8000:
            return []
        length = next(length for length in _LENGTHS if length >= len(answer))
        back = self.number << 8 | frame.identifier >> 8 & 0x7F
        return [CanFrame(back, answer.ljust(length, b"\x50"), back > 0x7FF, True)]

    def tick(self, period_s: float) -> list[CanFrame]:
        if self.mode == _POSITION:
            self._left_s -= period_s
            if self._left_s <= 0.0:
                self.mode = _TIMEOUT
        return []

    def trip(self, code: int) -> None:
        """Fall into a fault, as on a bench."""
        self.mode, self.fault = _FAULT, code

    def _write(self, first: int, values: list[float]) -> None:
        for place, value in enumerate(values, first):
            if place == 0:
                if int(value) == _STOPPED:
                    self.mode, self.fault = _STOPPED, 0
                elif self.mode not in (_FAULT, _TIMEOUT):
                    self.mode = int(value)
                    self._registers = {}
                    self._left_s = 0.1
            else:
                self._registers[place] = value
                if place == 0x27:
                    self._left_s = value

    def _read(self, register: int) -> float:
        shaft = self.shaft
        known = {
            0x00: float(self.mode),
            0x01: shaft.position_rad / _TURN,
            0x02: shaft.rate_rad_s / _TURN,
            0x03: shaft.torque_nm,
            0x0D: 24.0,
            0x0E: 31.0,
            0x0F: float(self.fault),
        }
        return known.get(register, 0.0)
