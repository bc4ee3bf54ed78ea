"""A servo that nobody makes, known by its DBC alone: what the adapter for mapped drives is held against."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import cantools

from firmware_protocol.adapters import CanFrame
from firmware_protocol.documents import yaml_text
from sim_backend.drives import Shaft
from tests.adapters.rig import AdapterRig
from tests.adapters.test_mapped import crc_of_j1850

DBC = """VERSION ""
NS_ :
BS_:
BU_: HOST SERVO
BO_ 256 Status: 8 SERVO
 SG_ Angle : 0|28@1- (0.0001,0) [-8000|8000] "deg" HOST
 SG_ Speed : 28|22@1- (0.001,0) [-2000|2000] "rpm" HOST
 SG_ Alive : 50|4@1+ (1,0) [0|15] "" HOST
 SG_ Check : 56|8@1+ (1,0) [0|255] "" HOST
BO_ 257 State: 1 SERVO
 SG_ State : 0|8@1+ (1,0) [0|255] "" HOST
BO_ 512 Command: 8 HOST
 SG_ Torque : 0|24@1- (0.1,0) [-800000|800000] "mN m" SERVO
 SG_ Run : 24|2@1+ (1,0) [0|3] "" SERVO
 SG_ Alive : 48|4@1+ (1,0) [0|15] "" SERVO
 SG_ Check : 56|8@1+ (1,0) [0|255] "" SERVO
VAL_ 257 State 15 "Overcurrent" 14 "Timeout" ;
"""
MAP: dict[str, Any] = {
    "schema": 1,
    "dbc": "servo.dbc",
    "id_step": 16,
    "feedback": {
        "position": {"message": "Status", "signal": "Angle", "unit": "deg"},
        "rate": {"message": "Status", "signal": "Speed", "unit": "rpm"},
    },
    "power": {"message": "State", "signal": "State", "on": [4], "stopping": [5], "fault": [14, 15]},
    "torque": {"message": "Command", "signal": "Torque", "unit": "mN m"},
    "enable": {"message": "Command", "signal": "Run", "on": 1, "off": 0, "reset": 2, "stop": 3},
    "messages": {
        "Status": {"counter": {"signal": "Alive"}, "crc": "Check"},
        "Command": {"counter": {"signal": "Alive"}, "crc": "Check"},
    },
}
_OFF, _ON, _STOPPING, _TIMEOUT, _OVERCURRENT = 0, 4, 5, 14, 15
_STATE_TICKS, _WATCHDOG_S = 5, 0.02
_STOP_NM_S, _MOST_NM = 20.0, 15.0


class SimulatedServo:
    """Tells its position every tick and its state every fifth; without commands it stops and says so."""

    def __init__(self, number: int) -> None:
        self.number, self.shaft, self.state = number, Shaft(), _OFF
        database: Any = cantools.database.load_string(DBC)
        self._messages = {one.name: one for one in database.messages}
        self._asked_nm, self._left_s, self._ticks, self._heard = 0.0, 0.0, 0, -1

    @property
    def torque_nm(self) -> float:
        if self.state == _STOPPING:
            return max(-_MOST_NM, min(_MOST_NM, -_STOP_NM_S * self.shaft.rate_rad_s))
        return self._asked_nm if self.state == _ON else 0.0

    def hear(self, frame: CanFrame) -> list[CanFrame]:
        if frame.identifier != 512 + 16 * self.number or frame.data[7] != crc_of_j1850(frame.data[:7]):
            return []
        values = self._messages["Command"].decode(frame.data, decode_choices=False)
        if values["Alive"] == self._heard:
            return []
        self._heard, run = values["Alive"], values["Run"]
        self._asked_nm, self._left_s = 1e-3 * values["Torque"], _WATCHDOG_S
        if self.state in (_TIMEOUT, _OVERCURRENT):
            self.state = _OFF if run == 2 else self.state
        elif run == 3:
            self.state = _STOPPING if self.state == _ON else self.state
        elif self.state != _STOPPING or run == 0:
            self.state = _ON if run == 1 else _OFF
        return []

    def tick(self, period_s: float) -> list[CanFrame]:
        self._ticks += 1
        self._left_s -= period_s
        if self._left_s <= 0.0 and self.state in (_ON, _STOPPING):
            self.state = _TIMEOUT
        status = {
            "Angle": math.degrees(self.shaft.position_rad),
            "Speed": self.shaft.rate_rad_s * 30.0 / math.pi,
            "Alive": self._ticks % 16,
            "Check": 0,
        }
        data = self._messages["Status"].encode(status)
        sent = [CanFrame(256 + 16 * self.number, data[:7] + bytes([crc_of_j1850(data[:7])]))]
        if self._ticks % _STATE_TICKS == 0:
            sent.append(CanFrame(257 + 16 * self.number, bytes([self.state])))
        return sent

    def trip(self, code: int = _OVERCURRENT) -> None:
        """Fall into a fault, as on a bench."""
        self.state = code


def mapped_files(folder: Path, rate_hz: float = 1000.0) -> dict[str, str]:
    """DBC and map of a servo that ticks at this rate, and what stands in its section because of that."""
    messages = MAP["messages"] | {"Status": MAP["messages"]["Status"] | {"rate_hz": rate_hz}}
    messages["State"] = {"rate_hz": rate_hz / _STATE_TICKS}
    (folder / "servo.dbc").write_text(DBC)
    (folder / "map.yaml").write_text(yaml_text(MAP | {"messages": messages}))
    return {"map": str(folder / "map.yaml")}


def mapped_rig(folder: Path, **more: Any) -> AdapterRig:
    """Two of these behind a host."""
    return AdapterRig("dbc", [SimulatedServo(number) for number in (1, 2)], link_more=mapped_files(folder), **more)
