"""ODrive: the CANSimple protocol, classic frames of identifier `node_id << 5 | command`.

Facts from ODrive's CAN protocol page (docs.odriverobotics.com, "CAN Protocol"): commands, fields, axis states, units of
turns. The drive sends by itself what its `can.*_msg_rate_ms` say: heartbeat, encoder estimates, torques, temperature
and bus voltage must be switched on there. What stops an axis whose host is gone is its own watchdog
(`config.enable_watchdog`, `config.watchdog_timeout`), which set-points feed; this side can neither set nor see it.
"""

from __future__ import annotations

import math
import struct
from dataclasses import replace

from firmware_protocol.adapters.drive import AxisSample, DriveTiming, Gives, Power
from firmware_protocol.adapters.spoken import Spoken
from firmware_protocol.errors import BadInputError
from firmware_protocol.links import CanFrame, DriveSection

HEARTBEAT, SET_AXIS_STATE, ENCODER_ESTIMATES, SET_CONTROLLER_MODE = 0x01, 0x07, 0x09, 0x0B
SET_INPUT_TORQUE, TEMPERATURE, BUS_VOLTAGE, CLEAR_ERRORS, TORQUES = 0x0E, 0x15, 0x17, 0x18, 0x1C
IDLE, CLOSED_LOOP = 1, 8
_WORDS = {
    HEARTBEAT: "heartbeat",
    ENCODER_ESTIMATES: "encoder estimates",
    TORQUES: "torques",
    TEMPERATURE: "temperature",
    BUS_VOLTAGE: "bus voltage",
}
_TORQUE_CONTROL, _PASS_THROUGH = 1, 1
_TURN = 2.0 * math.pi
#: power while there is no error; every other state of an axis (calibration, homing) has torque of its own
_POWERS = {0: Power.OFF, IDLE: Power.OFF, CLOSED_LOOP: Power.ON}
#: node_id has six bits of the identifier
_LAST_NODE = 63
#: its state comes with the heartbeat, every 100 ms unless `can.heartbeat_msg_rate_ms` says otherwise, s
_ANSWERS_S = 0.25
#: asking again for a state before the heartbeat has told of the last one helps nobody
_ASK_EVERY = 50


class OdriveDrive:
    """One axis of an ODrive."""

    is_asked = False
    gives = frozenset({Gives.RATE, Gives.TORQUE, Gives.TEMPERATURE, Gives.SUPPLY})

    def __init__(self, section: DriveSection, timing: DriveTiming) -> None:
        if section.id > _LAST_NODE:
            raise BadInputError("link.drives: id", f"{section.id} is no node_id", f"0 to {_LAST_NODE}")
        self._id, self.answers_s = section.id, _ANSWERS_S
        self._asked = self._words = 0
        self._told_power, self._error, self._invalid = Power.OFF, "", ""
        self.spoken = (
            Spoken(
                "heartbeat",
                f"power, wiring, bit rate (`can.config.baud_rate`), node_id {section.id} and "
                "`config.can.heartbeat_msg_rate_ms`",
            ),
            Spoken("encoder estimates", "`config.can.encoder_msg_rate_ms` at the control rate", 1.0 / timing.period_s),
        )
        self.sample = AxisSample(power_updates=0)

    def sender_of(self, frame: CanFrame) -> int | None:
        # what a host sends has these commands too, but never its heartbeat
        return None if frame.extended or frame.identifier & 0x1F != HEARTBEAT else frame.identifier >> 5

    def question_to(self, number: int) -> CanFrame | None:
        return None

    def word_of(self, frame: CanFrame) -> str:
        mine = not frame.extended and frame.identifier >> 5 == self._id
        return _WORDS.get(frame.identifier & 0x1F, "") if mine else ""

    def begin(self) -> list[CanFrame]:
        return [self._frame(SET_CONTROLLER_MODE, struct.pack("<II", _TORQUE_CONTROL, _PASS_THROUGH))]

    def ask(self) -> list[CanFrame]:
        return []

    def enable(self) -> list[CanFrame]:
        self._asked += 1
        if self._asked % _ASK_EVERY != 1:
            return self.command(0.0)
        mode = self._frame(SET_CONTROLLER_MODE, struct.pack("<II", _TORQUE_CONTROL, _PASS_THROUGH))
        return [mode, *self.command(0.0), self._state(CLOSED_LOOP)]

    def command(self, torque_nm: float) -> list[CanFrame]:
        return [self._frame(SET_INPUT_TORQUE, struct.pack("<f", torque_nm))]

    def leave(self) -> list[CanFrame]:
        return []

    def release(self) -> list[CanFrame]:
        self._asked = 0
        return [self._frame(SET_INPUT_TORQUE, struct.pack("<f", 0.0)), self._state(IDLE)]

    def stop(self) -> list[CanFrame]:
        return self.release()

    def starve(self) -> list[CanFrame]:
        # a set-point would feed its watchdog
        return [self._state(IDLE)]

    def reset(self) -> list[CanFrame]:
        return [*self.release(), self._frame(CLEAR_ERRORS, b"\x00")]

    def take(self, frame: CanFrame) -> bool:
        if frame.extended or frame.identifier >> 5 != self._id:
            return False
        command, data = frame.identifier & 0x1F, frame.data
        if command == HEARTBEAT and len(data) >= 5:
            errors, state = struct.unpack_from("<IB", data)
            self._told_power = _POWERS.get(state, Power.STOPPING)
            self._error = f"ODrive error 0x{errors:08X}" if errors else ""
            self._words += 1
            self._judge()
            return True
        if command not in (ENCODER_ESTIMATES, TORQUES, TEMPERATURE, BUS_VOLTAGE) or len(data) < 8:
            return False
        first, second = struct.unpack_from("<ff", data)
        if not (math.isfinite(first) and math.isfinite(second)):
            self._invalid = f"ODrive message 0x{command:02X} holds no number"
            self._judge()
        elif command == ENCODER_ESTIMATES:
            place, rate = first * _TURN, second * _TURN
            self.sample = replace(self.sample, updates=self.sample.updates + 1, position_rad=place, rate_rad_s=rate)
            if self._invalid:
                self._invalid = ""
                self._judge()
        elif command == TORQUES:
            self.sample = replace(self.sample, torque_nm=second)
        elif command == TEMPERATURE:
            self.sample = replace(self.sample, temperature_degc=second)
        else:
            self.sample = replace(self.sample, supply_v=first)
        return True

    def _judge(self) -> None:
        """Power from the last heartbeat and from whether its numbers were any."""
        fault = self._error or self._invalid
        power = self._told_power
        if fault:
            power = Power.REACTING if power.is_powered else Power.FAULT
        self.sample = replace(self.sample, power=power, fault=fault, power_updates=self._words)

    def _state(self, state: int) -> CanFrame:
        return self._frame(SET_AXIS_STATE, struct.pack("<I", state))

    def _frame(self, command: int, data: bytes) -> CanFrame:
        return CanFrame(self._id << 5 | command, data)
