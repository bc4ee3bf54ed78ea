"""A CANopen drive with the profile CiA 402: object dictionary by SDO, PDOs as mapped, states, heartbeat watched."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass

from firmware_protocol.adapters import CanFrame
from sim_backend.drives.axis import Shaft

_PRE_OPERATIONAL, _OPERATIONAL = 0x7F, 0x05
_SWITCH_ON_DISABLED, _READY, _SWITCHED_ON, _ENABLED, _QUICK_STOP, _FAULT = 0x40, 0x21, 0x23, 0x27, 0x07, 0x08
_SIZES = {0x2F: 1, 0x2B: 2, 0x23: 4}
_NO_OBJECT = 0x0602_0000
_CYCLIC_POSITION, _CYCLIC_TORQUE = 8, 10
_CONTROLWORD, _TARGET_TORQUE, _TARGET_POSITION = 0x6040_0010, 0x6071_0010, 0x607A_0020
_RATE_OFFSET, _TORQUE_OFFSET = 0x60B1_0020, 0x60B2_0010
#: what may be mapped into the two commands
_COMMANDED = {_CONTROLWORD: "H", _TARGET_TORQUE: "h", _TARGET_POSITION: "i", _RATE_OFFSET: "i", _TORQUE_OFFSET: "h"}
_COMMAND_PDOS = ((0x1400, 0x1600), (0x1401, 0x1601))


@dataclass
class PositionGains:
    """A drive's own loops in mode 8 (1/s, N m s/rad, N m/rad at the shaft), which every maker sets in its own way."""

    position: float = 0.0
    rate: float = 0.0
    integral: float = 0.0


class SimulatedCia402:
    """One node; torque in thousandths of `rated_nm`, position in `counts` a turn. The torque offset (0x60B2) is added
    in cyclic synchronous position (8) and torque (10) mode alike.
    """

    def __init__(self, number: int, rated_nm: float, counts: float, watches: bool = True) -> None:
        self.number, self.shaft, self._rated, self._radian = number, Shaft(), rated_nm, 2.0 * math.pi / counts
        self._watches = watches
        self.objects: dict[tuple[int, int], int] = {}
        self.network, self.status = _PRE_OPERATIONAL, _SWITCH_ON_DISABLED
        self._control, self._left_s = 0, math.inf
        self._commanded: dict[int, int] = {}
        self._integral_nm = 0.0
        self.gains = PositionGains()

    @property
    def torque_nm(self) -> float:
        mode = self.objects.get((0x6060, 0))
        if self.network != _OPERATIONAL or self.status != _ENABLED or mode not in (_CYCLIC_POSITION, _CYCLIC_TORQUE):
            return 0.0
        offset = self._commanded.get(_TORQUE_OFFSET, 0)
        if mode == _CYCLIC_TORQUE:
            return 1e-3 * (self._commanded.get(_TARGET_TORQUE, 0) + offset) * self._rated
        return self.gains.rate * self._slower() + self._integral_nm + 1e-3 * offset * self._rated

    def _slower(self) -> float:
        """How much slower (rad/s) the shaft is than the position loop wants it."""
        behind = self._commanded.get(_TARGET_POSITION, 0) * self._radian - self.shaft.position_rad
        wanted = self.gains.position * behind + self._commanded.get(_RATE_OFFSET, 0) * self._radian
        return wanted - self.shaft.rate_rad_s

    def hear(self, frame: CanFrame) -> list[CanFrame]:
        identifier, data = frame.identifier, frame.data
        if identifier == 0x000 and len(data) == 2 and data[1] in (0, self.number):
            self.network = {1: _OPERATIONAL, 0x80: _PRE_OPERATIONAL}.get(data[0], self.network)
        elif identifier == 0x600 + self.number:
            return [CanFrame(0x580 + self.number, self._write(data))]
        elif identifier in (self.objects.get((p, 1)) for p, _ in _COMMAND_PDOS) and self.network == _OPERATIONAL:
            mapping = next(mapping for p, mapping in _COMMAND_PDOS if self.objects.get((p, 1)) == identifier)
            self._command(data, mapping)
        elif identifier == 0x80 and self.network == _OPERATIONAL:
            return [*self._mapped(0x1800, 0x1A00), *self._mapped(0x1801, 0x1A01)]
        else:
            watched = self.objects.get((0x1016, 1), 0)
            if watched and identifier == 0x700 + (watched >> 16):
                self._left_s = 1e-3 * (watched & 0xFFFF)
        return []

    def tick(self, period_s: float) -> list[CanFrame]:
        self._left_s -= period_s
        if self._left_s <= 0.0 and self.status == _ENABLED:
            self.status = _FAULT
        if self.status == _ENABLED and self.objects.get((0x6060, 0)) == _CYCLIC_POSITION:
            self._integral_nm += self.gains.integral * self._slower() * period_s
        return []

    def trip(self) -> None:
        """Fall into a fault, as on a bench."""
        self.status = _FAULT

    def _write(self, data: bytes) -> bytes:
        size = _SIZES.get(data[0])
        index, sub = struct.unpack_from("<HB", data, 1)
        if size is None or (index == 0x1016 and not self._watches):
            return struct.pack("<BHBI", 0x80, index, sub, _NO_OBJECT)
        self.objects[index, sub] = int.from_bytes(data[4 : 4 + size], "little")
        return struct.pack("<BHBI", 0x60, index, sub, 0)

    def _mapped(self, parameters: int, mapping: int) -> list[CanFrame]:
        identifier = self.objects.get((parameters, 1), 0x8000_0000)
        if identifier & 0x8000_0000 or self.objects.get((parameters, 2)) != 1:
            return []
        values = {
            0x60410010: struct.pack("<H", self.status | 0x1200),
            0x60640020: struct.pack("<i", round(self.shaft.position_rad / self._radian)),
            0x606C0020: struct.pack("<i", round(self.shaft.rate_rad_s / self._radian)),
            0x60770010: struct.pack("<h", round(1e3 * self.shaft.torque_nm / self._rated)),
        }
        count = self.objects.get((mapping, 0), 0)
        return [CanFrame(identifier, b"".join(values[self.objects[mapping, place]] for place in range(1, count + 1)))]

    def _command(self, data: bytes, mapping: int) -> None:
        mapped = [self.objects[mapping, place] for place in range(1, self.objects.get((mapping, 0), 0) + 1)]
        values = struct.unpack("<" + "".join(_COMMANDED[one] for one in mapped), data)
        self._commanded |= dict(zip(mapped, values, strict=True))
        if _CONTROLWORD in mapped:
            self._hear_control(self._commanded[_CONTROLWORD])

    def _hear_control(self, control: int) -> None:
        rose, self._control = control & ~self._control, control
        if self.status == _FAULT:
            if rose & 0x80:
                self.status = _SWITCH_ON_DISABLED
        elif not control & 0x02:
            self.status = _SWITCH_ON_DISABLED
        elif not control & 0x04:
            self.status = _QUICK_STOP if self.status == _ENABLED else _SWITCH_ON_DISABLED
        elif control & 0x0F == 0x06:
            self.status = _READY if self.status != _QUICK_STOP else _SWITCH_ON_DISABLED
        elif control & 0x0F == 0x07 and self.status in (_READY, _ENABLED):
            self.status = _SWITCHED_ON
        elif control & 0x0F == 0x0F and self.status == _SWITCHED_ON:
            self.status = _ENABLED
