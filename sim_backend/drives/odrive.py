"""An ODrive axis: CANSimple (docs.odriverobotics.com, "CAN Protocol"), with its watchdog switched on."""

from __future__ import annotations

import math
import struct

from firmware_protocol.adapters import CanFrame
from sim_backend.drives.axis import Shaft

_TURN = 2.0 * math.pi
_IDLE, _CLOSED_LOOP = 1, 8
_WATCHDOG_EXPIRED = 0x0100_0000
_HEARTBEAT_TICKS, _SLOW_TICKS = 10, 100


class SimulatedOdrive:
    """One axis with this node id; `watchdog_s` as its configuration would have it."""

    def __init__(self, number: int, watchdog_s: float = 0.05) -> None:
        self.number, self.shaft, self.watchdog_s = number, Shaft(), watchdog_s
        self.state, self.errors = _IDLE, 0
        self._mode, self._input_nm, self._left_s, self._ticks = (0, 0), 0.0, 0.0, 0

    @property
    def torque_nm(self) -> float:
        return self._input_nm if self.state == _CLOSED_LOOP else 0.0

    def hear(self, frame: CanFrame) -> list[CanFrame]:
        if frame.extended or frame.fd or frame.identifier >> 5 != self.number:
            return []
        command = frame.identifier & 0x1F
        if command == 0x07:
            (wanted,) = struct.unpack("<I", frame.data)
            if wanted == _IDLE or (wanted == _CLOSED_LOOP and not self.errors):
                self.state, self._left_s = wanted, self.watchdog_s
        elif command == 0x0B:
            self._mode = struct.unpack("<II", frame.data)
        elif command == 0x0E:
            (self._input_nm,) = struct.unpack("<f", frame.data[:4])
            self._left_s = self.watchdog_s
        elif command == 0x18:
            self.errors = 0
        return []

    def tick(self, period_s: float) -> list[CanFrame]:
        self._ticks += 1
        if self.state == _CLOSED_LOOP:
            self._left_s -= period_s
            if self._left_s <= 0.0 or self._mode != (1, 1):
                self.state, self.errors = _IDLE, _WATCHDOG_EXPIRED
        sent = [self._frame(0x09, struct.pack("<ff", self.shaft.position_rad / _TURN, self.shaft.rate_rad_s / _TURN))]
        if self._ticks % _HEARTBEAT_TICKS == 0:
            sent.append(self._frame(0x01, struct.pack("<IBBBB", self.errors, self.state, 0, 0, 0)))
        if self._ticks % _SLOW_TICKS == 0:
            sent.append(self._frame(0x1C, struct.pack("<ff", self._input_nm, self.shaft.torque_nm)))
            sent.append(self._frame(0x15, struct.pack("<ff", 30.0, 35.0)))
            sent.append(self._frame(0x17, struct.pack("<ff", 48.0, 0.5)))
        return sent

    def trip(self, errors: int) -> None:
        """Fall into a fault, as on a bench."""
        self.state, self.errors = _IDLE, errors

    def _frame(self, command: int, data: bytes) -> CanFrame:
        return CanFrame(self.number << 5 | command, data)
