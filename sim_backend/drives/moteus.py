"""A moteus controller: register reads and writes in CAN-FD frames, after the controller reference of mjbots.

Its own position loop (`servo.pid_position`, in turns) works where a command does not scale its gains to zero. In
position mode the commutation encoder's place in its turn selects a current out of `motor.cogging_dq_comp` (1024 signed
bytes, linear between them, times `motor.cogging_dq_scale` in A), which is added to what the loop asks for. In mode 15
its winding is shorted, which slows the shaft by what the torque constant and the winding's resistance make of its rate.
"""

from __future__ import annotations

import math
import struct

from firmware_protocol.adapters import CanFrame
from sim_backend.drives.axis import Shaft

_TURN = 2.0 * math.pi
_SIZES = {0: (1, "b"), 4: (2, "h"), 8: (4, "i"), 12: (4, "f")}
_STOPPED, _FAULT, _POSITION, _TIMEOUT, _ZERO_VELOCITY, _SHORTED = 0, 1, 10, 11, 12, 15
_LENGTHS = (*range(9), 12, 16, 20, 24, 32, 48, 64)
_TABLE_SIZE = 1024
#: of a winding of the size that its torque constant has, ohm
_RESISTANCE_OHM = 0.05
_COMMAND_POSITION, _COMMAND_VELOCITY, _COMMAND_TORQUE, _KP_SCALE, _KD_SCALE = range(0x20, 0x25)


class SimulatedMoteus:
    """One controller with the id `number`, its motor's torque constant (N m/A at the rotor), and how the commutation
    encoder reads: `rotor_turns` for one of the shaft (negative: backwards), `rotor_zero` turns where the shaft is at
    zero.
    """

    def __init__(
        self, number: int, torque_constant: float = 0.1, rotor_turns: float = 1.0, rotor_zero: float = 0.0
    ) -> None:
        self.number, self.shaft = number, Shaft()
        self.mode, self.fault = _STOPPED, 0
        self._torque_constant, self._rotor_turns, self._rotor_zero = torque_constant, rotor_turns, rotor_zero
        self._gains = {"kp": 0.0, "ki": 0.0, "kd": 0.0}
        self._integral_nm = 0.0
        self._scale, self._table = 0.0, [0] * _TABLE_SIZE
        self._registers: dict[int, float] = {}
        self._left_s = 0.0

    @property
    def torque_nm(self) -> float:
        if self.mode == _SHORTED:
            return -(self._torque_constant**2) / _RESISTANCE_OHM * self.shaft.rate_rad_s
        if self.mode == _ZERO_VELOCITY:
            return -self._gains["kd"] * self.shaft.rate_rad_s / _TURN
        if self.mode != _POSITION:
            return 0.0
        behind, slower = self._errors()
        asked = self._integral_nm + self._registers.get(_COMMAND_TORQUE, 0.0)
        asked += self._gains["kp"] * self._registers.get(_KP_SCALE, 1.0) * behind
        asked += self._gains["kd"] * self._registers.get(_KD_SCALE, 1.0) * slower
        return asked + self._cogging_a() * self._torque_constant * abs(self._rotor_turns)

    def configure(self, line: str) -> None:
        """`conf set` with this key and value, as a line of `moteus_tool --restore-config` has them."""
        key, value = line.split("#")[0].split()
        group, _, last = key.rpartition(".")
        if key == "motor.cogging_dq_scale":
            self._scale = float(value)
        elif group == "motor.cogging_dq_comp":
            if not -128 <= int(value) <= 127:
                raise ValueError(f"{key} is a signed byte, not {value}")
            self._table[int(last)] = int(value)
        elif group == "servo.pid_position" and last in self._gains:
            self._gains[last] = float(value)
        else:
            raise ValueError(f"no key {key}")

    def _errors(self) -> tuple[float, float]:
        """How far (turns) and by how much (turns/s) the shaft is behind its command; none where there is none."""
        wanted, speed = self._registers.get(_COMMAND_POSITION, math.nan), self._registers.get(_COMMAND_VELOCITY, 0.0)
        behind = 0.0 if math.isnan(wanted) else wanted - self.shaft.position_rad / _TURN
        return behind, (0.0 if math.isnan(speed) else speed) - self.shaft.rate_rad_s / _TURN

    def _cogging_a(self) -> float:
        """The table's current at the commutation encoder's place."""
        place = (self.shaft.position_rad / _TURN * self._rotor_turns + self._rotor_zero) % 1.0 * _TABLE_SIZE
        left = min(int(place), _TABLE_SIZE - 1)
        low, high = self._table[left], self._table[(left + 1) % _TABLE_SIZE]
        return self._scale * (low + (high - low) * (place - left))

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
            scale = self._registers.get(_KP_SCALE, 1.0)
            self._integral_nm += self._gains["ki"] * scale * self._errors()[0] * period_s
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
