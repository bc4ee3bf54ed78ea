"""An ODrive axis: CANSimple (docs.odriverobotics.com, "CAN Protocol"), with its watchdog switched on.

In position control its own cascade works (`pos_gain`, `vel_gain`, `vel_integrator_gain`, in turns). In every control
mode the torque at the place of the encoder in its turn is taken from a map of 3600 and added.
"""

from __future__ import annotations

import math
import struct

from firmware_protocol.adapters import CanFrame
from sim_backend.drives.axis import Shaft

_TURN = 2.0 * math.pi
_IDLE, _CLOSED_LOOP = 1, 8
_WATCHDOG_EXPIRED = 0x0100_0000
_HEARTBEAT_TICKS, _SLOW_TICKS = 10, 100
_TORQUE_CONTROL, _POSITION_CONTROL, _PASS_THROUGH = 1, 3, 1
_MAP_SIZE = 3600


class SimulatedOdrive:
    """One axis with this node id; `watchdog_s` as its configuration would have it."""

    def __init__(self, number: int, watchdog_s: float = 0.05) -> None:
        self.number, self.shaft, self.watchdog_s = number, Shaft(), watchdog_s
        self.state, self.errors = _IDLE, 0
        self._mode, self._input_nm, self._left_s, self._ticks = (0, 0), 0.0, 0.0, 0
        self._input_turns, self._input_turns_s = 0.0, 0.0
        #: turn/s a turn, N m a turn/s, N m/s a turn/s
        self.pos_gain, self.vel_gain, self.vel_integrator_gain = 20.0, 0.16, 0.32
        self._integral_nm = 0.0
        #: `can.input_vel_scale` and `can.input_torque_scale`: what one turn/s and one N m are in Set_Input_Pos
        self.input_vel_scale, self.input_torque_scale = 1000, 1000
        self.cogging_map = [0.0] * _MAP_SIZE
        self.anticogging_enabled = False

    @property
    def torque_nm(self) -> float:
        if self.state != _CLOSED_LOOP:
            return 0.0
        loop = 0.0
        if self._mode[0] == _POSITION_CONTROL:
            loop = self.vel_gain * self._slower() + self._integral_nm
        return self._input_nm + loop + self._cogging_nm()

    def set_anticogging_value(self, index: int, torque_nm: float) -> None:
        """One place of the map, as firmware with such a function takes it."""
        self.cogging_map[index] = torque_nm

    def _slower(self) -> float:
        """How much slower (turns/s) the shaft is than the position loop wants it."""
        behind = self._input_turns - self.shaft.position_rad / _TURN
        return self._input_turns_s + self.pos_gain * behind - self.shaft.rate_rad_s / _TURN

    def _cogging_nm(self) -> float:
        if not self.anticogging_enabled:
            return 0.0
        return self.cogging_map[math.floor(self.shaft.position_rad / _TURN * _MAP_SIZE) % _MAP_SIZE]

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
        elif command == 0x0C:
            self._input_turns, speed, torque = struct.unpack("<fhh", frame.data)
            self._input_turns_s, self._input_nm = speed / self.input_vel_scale, torque / self.input_torque_scale
            self._left_s = self.watchdog_s
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
            if self._mode[0] == _POSITION_CONTROL:
                self._integral_nm += self.vel_integrator_gain * self._slower() * period_s
            if self._left_s <= 0.0 or self._mode not in (
                (_TORQUE_CONTROL, _PASS_THROUGH),
                (_POSITION_CONTROL, _PASS_THROUGH),
            ):
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
