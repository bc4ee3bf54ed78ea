"""A CANopen drive with the profile CiA 402: states and options as the profile has them, nothing more lenient.

Facts from CiA 402 / IEC 61800-7-201 (state machine with its transitions 2 to 16, options 0x605A, 0x605E and 0x6007) and
CiA 301 (SDO, PDO, NMT, heartbeat consumer 0x1016, error behaviour 0x1029, emergency). The object dictionary is in
`cia402_objects.py`.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass

from firmware_protocol.adapters import CanFrame
from sim_backend.drives.axis import Shaft
from sim_backend.drives.cia402_objects import Dictionary

_PRE_OPERATIONAL, _OPERATIONAL, _STOPPED = 0x7F, 0x05, 0x04
_NETWORK = {0x01: _OPERATIONAL, 0x02: _STOPPED, 0x80: _PRE_OPERATIONAL}
_SWITCH_ON_DISABLED, _READY, _SWITCHED_ON, _ENABLED = 0x40, 0x21, 0x23, 0x27
_QUICK_STOP, _REACTING, _FAULT = 0x07, 0x0F, 0x08
_CYCLIC_POSITION, _CYCLIC_TORQUE = 8, 10
_CONTROLWORD, _TARGET_TORQUE, _TARGET_POSITION = 0x6040_0010, 0x6071_0010, 0x607A_0020
_RATE_OFFSET, _TORQUE_OFFSET = 0x60B1_0020, 0x60B2_0010
#: what may be mapped into the two commands
_COMMANDED = {_CONTROLWORD: "H", _TARGET_TORQUE: "h", _TARGET_POSITION: "i", _RATE_OFFSET: "i", _TORQUE_OFFSET: "h"}
_COMMAND_PDOS = ((0x1400, 0x1600), (0x1401, 0x1601))
_HEARTBEAT_LOST, _NO_ERROR = 0x8130, 0x0000
#: options of 0x6007 (connection lost); 0 does nothing
_LOST_FAULT, _LOST_DISABLE, _LOST_QUICK_STOP = 1, 2, 3
#: options of 0x605A from which on a drive that has stopped stays under torque
_STAYS = 5
#: a shaft slower than this is at rest, rad/s; torque of a stop for a difference in rate, rated torques for one rad/s
_REST_RAD_S, _STOP_GAIN_S = 0.05, 2.0


@dataclass
class PositionGains:
    """A drive's own loops in mode 8 (1/s, N m s/rad, N m/rad at the shaft), which every maker sets in its own way."""

    position: float = 0.0
    rate: float = 0.0
    integral: float = 0.0


class SimulatedCia402:
    """One node; torque in thousandths of `rated_nm`, position in `counts` a turn. The torque offset (0x60B2) is added
    in cyclic synchronous position (8) and torque (10) mode alike. One that does not watch refuses 0x1016.
    """

    def __init__(self, number: int, rated_nm: float, counts: float, watches: bool = True) -> None:
        self.number, self.shaft, self._rated, self._radian = number, Shaft(), rated_nm, 2.0 * math.pi / counts
        self.objects = Dictionary(number, counts, watches)
        self.network, self.status = _PRE_OPERATIONAL, _SWITCH_ON_DISABLED
        self._control, self._ramp_rad_s = 0, 0.0
        self._commanded: dict[int, int] = {}
        self._integral_nm = 0.0
        self.gains = PositionGains()
        #: time left of the heartbeat consumer, which counts from the first heartbeat on
        self._left_s = math.inf
        self._outbox: list[CanFrame] = []

    @property
    def torque_nm(self) -> float:
        if self.status == _ENABLED:
            return self._following_nm()
        if self.status in (_QUICK_STOP, _REACTING):
            wanted = _STOP_GAIN_S * (self._ramp_rad_s - self.shaft.rate_rad_s)
            return max(-1.0, min(1.0, wanted)) * self._rated
        return 0.0

    def _following_nm(self) -> float:
        """What its mode makes of the last commands."""
        offset = self._commanded.get(_TORQUE_OFFSET, 0)
        if self.objects[0x6060, 0] == _CYCLIC_TORQUE:
            return 1e-3 * (self._commanded.get(_TARGET_TORQUE, 0) + offset) * self._rated
        if self.objects[0x6060, 0] == _CYCLIC_POSITION:
            return self.gains.rate * self._slower() + self._integral_nm + 1e-3 * offset * self._rated
        return 0.0

    def _slower(self) -> float:
        """How much slower (rad/s) the shaft is than the position loop wants it."""
        behind = self._commanded.get(_TARGET_POSITION, 0) * self._radian - self.shaft.position_rad
        wanted = self.gains.position * behind + self._commanded.get(_RATE_OFFSET, 0) * self._radian
        return wanted - self.shaft.rate_rad_s

    def hear(self, frame: CanFrame) -> list[CanFrame]:
        identifier, data = frame.identifier, frame.data
        if identifier == 0x000 and len(data) == 2 and data[1] in (0, self.number):
            self._enter(_NETWORK.get(data[0], self.network))
        elif identifier == 0x600 + self.number and len(data) == 8 and self.network != _STOPPED:
            self.objects.now[0x6041, 0] = self.status
            return [CanFrame(0x580 + self.number, self.objects.answer(data))]
        elif identifier in (self.objects[place, 1] for place, _ in _COMMAND_PDOS) and self.network == _OPERATIONAL:
            mapping = next(mapping for place, mapping in _COMMAND_PDOS if self.objects[place, 1] == identifier)
            self._command(data, mapping)
        elif identifier == 0x80 and self.network == _OPERATIONAL:
            return [*self._mapped(0x1800, 0x1A00), *self._mapped(0x1801, 0x1A01)]
        elif (watched := self.objects[0x1016, 1]) and identifier == 0x700 + (watched >> 16):
            self._left_s = 1e-3 * (watched & 0xFFFF)
        return []

    def tick(self, period_s: float) -> list[CanFrame]:
        self._left_s -= period_s
        if self._left_s <= 0.0:
            self._left_s = math.inf
            self._emergency(_HEARTBEAT_LOST)
            if self.objects[0x1029, 1] == 0 and self.network == _OPERATIONAL:
                self.network = _PRE_OPERATIONAL
            self._connection_lost()
        if self.status in (_QUICK_STOP, _REACTING):
            self._slow_down(period_s)
        elif self.status == _ENABLED and self.objects[0x6060, 0] == _CYCLIC_POSITION:
            self._integral_nm += self.gains.integral * self._slower() * period_s
        sent, self._outbox = self._outbox, []
        return sent

    def trip(self, code: int = 0x7305) -> None:
        """Fall into a fault, as on a bench."""
        self._emergency(code)
        self._fail()

    def start_anew(self) -> None:
        """As after a dip of its supply: nothing that was set up is left, and a boot-up message says so."""
        self.objects = Dictionary(self.number, 2.0 * math.pi / self._radian, self.objects.watches)
        self.network, self.status, self._left_s = _PRE_OPERATIONAL, _SWITCH_ON_DISABLED, math.inf
        self._control, self._commanded, self._integral_nm = 0, {}, 0.0
        self._outbox = [CanFrame(0x700 + self.number, b"\x00")]

    def _enter(self, network: int) -> None:
        stopped, self.network = network == _STOPPED and self.network != _STOPPED, network
        if stopped:
            self._connection_lost()

    def _connection_lost(self) -> None:
        option = self.objects[0x6007, 0]
        if option == _LOST_FAULT and self.status not in (_REACTING, _FAULT):
            self._fail()
        elif option == _LOST_DISABLE and self.status not in (_REACTING, _FAULT):
            self.status = _SWITCH_ON_DISABLED
        elif option == _LOST_QUICK_STOP:
            self._stop_quickly()

    def _fail(self) -> None:
        """Transition 13; what is not under torque has nothing to react with."""
        powered = self.status in (_ENABLED, _QUICK_STOP)
        self.status = _REACTING if powered and self.objects[0x605E, 0] != 0 else _FAULT
        self._ramp_rad_s = self.shaft.rate_rad_s

    def _stop_quickly(self) -> None:
        """Transition 11 with torque, 7 and 10 without; option 0 switches off at once."""
        if self.status == _ENABLED and self.objects[0x605A, 0] != 0:
            self.status, self._ramp_rad_s = _QUICK_STOP, self.shaft.rate_rad_s
        elif self.status in (_READY, _SWITCHED_ON, _ENABLED):
            self.status = _SWITCH_ON_DISABLED

    def _slow_down(self, period_s: float) -> None:
        """The reference goes to zero at 0x6085; a stop is over once both it and the shaft are at rest."""
        step = self.objects[0x6085, 0] * self._radian * period_s
        self._ramp_rad_s -= math.copysign(min(step, abs(self._ramp_rad_s)), self._ramp_rad_s)
        if self._ramp_rad_s == 0.0 and abs(self.shaft.rate_rad_s) < _REST_RAD_S:
            if self.status == _REACTING:
                self.status = _FAULT
            elif self.objects[0x605A, 0] < _STAYS:
                self.status = _SWITCH_ON_DISABLED

    def _emergency(self, code: int) -> None:
        self.objects.now[0x603F, 0] = code
        self._outbox.append(CanFrame(0x80 + self.number, struct.pack("<HB5x", code, 0x01 if code else 0x00)))

    def _mapped(self, parameters: int, mapping: int) -> list[CanFrame]:
        identifier = self.objects[parameters, 1]
        if identifier & 0x8000_0000 or self.objects[parameters, 2] != 1:
            return []
        values = {
            0x60410010: struct.pack("<H", self.status | 0x1200),
            0x60640020: struct.pack("<i", round(self.shaft.position_rad / self._radian)),
            0x606C0020: struct.pack("<i", round(self.shaft.rate_rad_s / self._radian)),
            0x60770010: struct.pack("<h", round(1e3 * self.shaft.torque_nm / self._rated)),
        }
        mapped = [self.objects[mapping, place] for place in range(1, self.objects[mapping, 0] + 1)]
        return [CanFrame(identifier, b"".join(values[entry] for entry in mapped))]

    def _command(self, data: bytes, mapping: int) -> None:
        """A command as it is mapped; one of another length is none."""
        mapped = [self.objects[mapping, place] for place in range(1, self.objects[mapping, 0] + 1)]
        form = struct.Struct("<" + "".join(_COMMANDED[one] for one in mapped))
        if len(data) != form.size:
            return
        self._commanded |= dict(zip(mapped, form.unpack(data), strict=True))
        if _CONTROLWORD in mapped:
            self._hear_control(self._commanded[_CONTROLWORD])

    def _hear_control(self, control: int) -> None:
        """The transition that a controlword is, if it is one from here."""
        rose, self._control = control & ~self._control, control
        if self.status in (_REACTING, _FAULT):
            if self.status == _FAULT and rose & 0x80:
                self.status = _SWITCH_ON_DISABLED
                self._emergency(_NO_ERROR)
        elif control & 0x80:
            return
        elif not control & 0x02:
            self.status = _SWITCH_ON_DISABLED
        elif not control & 0x04:
            self._stop_quickly()
        elif self.status == _QUICK_STOP:
            # transition 16, which only a drive that stays has; "shut down" and "switch on" lead nowhere from here
            if control & 0x0F == 0x0F and self.objects[0x605A, 0] >= _STAYS:
                self.status = _ENABLED
        elif control & 0x07 == 0x06:
            self.status = _READY
        elif control & 0x0F == 0x07:
            if self.status in (_READY, _ENABLED):
                self.status = _SWITCHED_ON
        elif self.status == _SWITCHED_ON:
            self.status = _ENABLED
