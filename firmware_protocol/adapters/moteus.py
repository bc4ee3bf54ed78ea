"""moteus: CAN-FD frames of register reads and writes.

Facts from the moteus controller reference (mjbots/moteus on GitHub, sections A.1 and A.2): identifiers,
subframes, registers 0x000 to 0x00f and 0x020 to 0x027, units of turns. Torque control is position mode with both gains
scaled to zero; register 0x027 keeps each command valid for so long only, which is the deadman that stops a drive whose
host is gone. Its state after that is `timeout` (11), in which what it does is its own setting.
"""

from __future__ import annotations

import math
import struct
from dataclasses import replace

from firmware_protocol.adapters.drive import AxisSample, DriveTiming, Gives, Power
from firmware_protocol.adapters.spoken import Spoken
from firmware_protocol.links import CanFrame, DriveSection

_SOURCE, _REPLY = 0, 0x80
_WRITE_INT8, _WRITE_FLOAT, _READ_FLOAT, _READ_INT8 = 0x00, 0x0C, 0x1C, 0x10
_REPLY_INT8, _REPLY_INT16, _REPLY_INT32, _REPLY_FLOAT = 0x20, 0x24, 0x28, 0x2C
_NOP = 0x50
_MODE, _POSITION, _VELOCITY, _TORQUE, _VOLTAGE, _TEMPERATURE, _FAULT = 0x000, 0x001, 0x002, 0x003, 0x00D, 0x00E, 0x00F
_COMMAND = 0x020
_STOPPED, _IN_FAULT, _IN_POSITION, _TIMED_OUT, _ZERO_VELOCITY, _SHORTED = 0, 1, 10, 11, 12, 15
#: mode -> power. Out of time a controller does what its `servo.timeout_mode` says, which may be to hold, and takes
#: commands again only after a stop; enabling, calibrating (2 to 4) and a shorted winding apply no torque
_POWERS = {_IN_POSITION: Power.ON, _IN_FAULT: Power.FAULT, _TIMED_OUT: Power.REACTING}
_POWERS |= dict.fromkeys((_STOPPED, 2, 3, 4, _SHORTED), Power.OFF)
_FORMS = {_REPLY_INT8: "b", _REPLY_INT16: "h", _REPLY_INT32: "i", _REPLY_FLOAT: "f"}
#: lengths that an FD frame may have
_LENGTHS = (*range(9), 12, 16, 20, 24, 32, 48, 64)
_TURN = 2.0 * math.pi
#: mode, position, velocity, torque; voltage and temperature
_QUESTION = bytes([_READ_INT8 | 1, _MODE, _READ_FLOAT | 3, _POSITION, _READ_FLOAT | 3, _VOLTAGE])


def _fault_of(mode: int, code: int) -> str:
    """What moteus says of itself; the codes are those of its register 0x00f."""
    return "moteus: no command in its watchdog's time" if mode == _TIMED_OUT else f"moteus fault {code}"


class MoteusDrive:
    """One moteus controller."""

    is_asked = True
    gives = frozenset({Gives.RATE, Gives.TORQUE, Gives.TEMPERATURE, Gives.SUPPLY, Gives.SHORT})

    def __init__(self, section: DriveSection, timing: DriveTiming) -> None:
        self._id, self._watchdog_s = section.id, timing.watchdog_s
        self.answers_s = timing.watchdog_s
        self.spoken = (
            Spoken(
                "answer",
                f"power, wiring, id {section.id} (`moteus_tool --info`) and both bit rates; without CAN FD "
                "(link.data_bitrate) a moteus does not hear this side",
            ),
        )
        self.sample = AxisSample()

    def sender_of(self, frame: CanFrame) -> int | None:
        return frame.identifier >> 8 & 0x7F if frame.identifier & 0xFF == _SOURCE else None

    def question_to(self, number: int) -> CanFrame | None:
        return self._frame(_QUESTION, number)

    def word_of(self, frame: CanFrame) -> str:
        return "answer" if frame.identifier & 0xFFFF == (self._id << 8) | _SOURCE else ""

    def begin(self) -> list[CanFrame]:
        return []

    def ask(self) -> list[CanFrame]:
        return [self._frame(_QUESTION)]

    def enable(self) -> list[CanFrame]:
        return self.command(0.0)

    def command(self, torque_nm: float) -> list[CanFrame]:
        # 0x020 position (the present one), velocity, feed-forward torque, kp scale, kd scale; 0x027 watchdog
        values = struct.pack("<5f", math.nan, 0.0, torque_nm, 0.0, 0.0)
        write = bytes([_WRITE_INT8 | 1, _MODE, _IN_POSITION, _WRITE_FLOAT, 5, _COMMAND]) + values
        watchdog = bytes([_WRITE_FLOAT | 1, _COMMAND + 7]) + struct.pack("<f", self._watchdog_s)
        return [self._frame(write + watchdog + _QUESTION)]

    def leave(self) -> list[CanFrame]:
        return []

    def release(self) -> list[CanFrame]:
        return [self._to(_STOPPED)]

    def stop(self) -> list[CanFrame]:
        return [self._to(_ZERO_VELOCITY)]

    def short(self) -> list[CanFrame]:
        return [self._to(_SHORTED)]

    def starve(self) -> list[CanFrame]:
        # only a position command begins the watchdog's time anew
        return self.release()

    def reset(self) -> list[CanFrame]:
        return self.release()

    def take(self, frame: CanFrame) -> bool:
        if frame.identifier & 0xFFFF != (self._id << 8) | _SOURCE:
            return False
        values = replies(frame.data)
        if values is None or _MODE not in values or _POSITION not in values:
            return False
        mode = int(values[_MODE])
        power = _POWERS.get(mode, Power.STOPPING)
        if not all(math.isfinite(values.get(register, 0.0)) for register in (_POSITION, _VELOCITY, _TORQUE)):
            power = Power.REACTING if power.is_powered else Power.FAULT
            values |= {_POSITION: self.sample.position_rad / _TURN, _VELOCITY: 0.0, _TORQUE: 0.0}
        self.sample = replace(
            self.sample,
            updates=self.sample.updates + 1,
            position_rad=values[_POSITION] * _TURN,
            rate_rad_s=values.get(_VELOCITY, 0.0) * _TURN,
            torque_nm=values.get(_TORQUE, self.sample.torque_nm),
            supply_v=values.get(_VOLTAGE, self.sample.supply_v),
            temperature_degc=values.get(_TEMPERATURE, self.sample.temperature_degc),
            power=power,
            fault=_fault_of(mode, int(values.get(_FAULT, 0))) if power.is_faulty else "",
        )
        return True

    def _to(self, mode: int) -> CanFrame:
        return self._frame(bytes([_WRITE_INT8 | 1, _MODE, mode]) + _QUESTION)

    def _frame(self, data: bytes, number: int | None = None) -> CanFrame:
        length = next(length for length in _LENGTHS if length >= len(data))
        identifier = (_SOURCE | _REPLY) << 8 | (self._id if number is None else number)
        # an identifier of more than eleven bits makes the frame an extended one
        return CanFrame(identifier, data.ljust(length, bytes([_NOP])), extended=True, fd=True)


def replies(data: bytes) -> dict[int, float] | None:
    """Registers in the replies of a frame, floats only in their units and modes as numbers; None where it is broken."""
    found: dict[int, float] = {}
    at = 0
    while at < len(data):
        kind = data[at] & 0xFC
        if data[at] == _NOP:
            at += 1
            continue
        if kind not in _FORMS:
            return None
        count, at = data[at] & 3, at + 1
        if count == 0:
            if at >= len(data):
                return None
            count, at = data[at], at + 1
        if at >= len(data):
            return None
        register, at = data[at], at + 1
        form = struct.Struct(f"<{count}{_FORMS[kind]}")
        if at + form.size > len(data):
            return None
        found |= {register + place: float(value) for place, value in enumerate(form.unpack_from(data, at))}
        at += form.size
    return found
