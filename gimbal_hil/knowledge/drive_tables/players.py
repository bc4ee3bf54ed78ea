"""Set-points for the simulated drives' own loops, as a host sends them: position, rate and feed-forward torque."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Callable
from typing import Protocol

import numpy as np

from firmware_protocol.adapters import CanFrame
from gimbal_hil.knowledge.drive_tables.makes import MAKES
from gimbal_hil.knowledge.drive_tables.motor import DriveOfAxis
from gimbal_hil.knowledge.drive_tables.ripple import RippleTable
from sim_backend.drives import PositionGains, SimulatedCia402, SimulatedDrive, SimulatedMoteus, SimulatedOdrive

_TURN = 2.0 * math.pi


class Player(Protocol):
    """One drive with its loops closed by itself, and how a host speaks to it."""

    @property
    def drive(self) -> SimulatedDrive:
        """The drive on its bus."""

    def begin(self) -> list[CanFrame]:
        """Frames that switch it on."""

    def load(self, table: RippleTable) -> None:
        """Put the ripple's table into the drive."""

    def go(self, turns: float, turns_s: float, torque_nm: float) -> list[CanFrame]:
        """A set-point, at the shaft."""


class MoteusPlayer:
    """Position mode with `servo.pid_position`; torque in the feed-forward register."""

    def __init__(self, axis: DriveOfAxis, inertia: float, bandwidth: float) -> None:
        motor = axis.motor
        self._axis = axis
        self.drive = SimulatedMoteus(axis.section.id, motor.torque_constant or 0.1, motor.rotor_turns, motor.rotor_zero)
        for key, power, factor in (("kp", 2, 3.0), ("ki", 3, 1.0), ("kd", 1, 3.0)):
            self.drive.configure(f"servo.pid_position.{key} {factor * inertia * bandwidth**power * _TURN!r}")

    def begin(self) -> list[CanFrame]:
        return []

    def load(self, table: RippleTable) -> None:
        _, text = MAKES["moteus"].written(self._axis, table.torque_nm)
        for line in text.splitlines():
            if not line.startswith("#"):
                self.drive.configure(line)

    def go(self, turns: float, turns_s: float, torque_nm: float) -> list[CanFrame]:
        mode = bytes([0x01, 0x00, 10])
        # position, rate, torque beside, both gains as configured
        command = bytes([0x0C, 5, 0x20]) + struct.pack("<5f", turns, turns_s, torque_nm, 1.0, 1.0)
        data = mode + command + bytes([0x0D, 0x27]) + struct.pack("<f", 0.1)
        return [CanFrame(self.drive.number, data.ljust(48, b"\x50"), extended=True, fd=True)]


class OdrivePlayer:
    """Position control, pass-through; torque in `Set_Input_Pos`."""

    def __init__(self, axis: DriveOfAxis, inertia: float, bandwidth: float) -> None:
        self._axis = axis
        self.drive = SimulatedOdrive(axis.section.id)
        self.drive.pos_gain, self.drive.vel_gain = 0.5 * bandwidth, 3.0 * inertia * bandwidth * _TURN
        self.drive.vel_integrator_gain = inertia * bandwidth**2 * _TURN
        # a gimbal is slow: the usual step of 0.001 turn/s is a quarter of its speed in the swing
        self.drive.input_vel_scale = 50000

    def begin(self) -> list[CanFrame]:
        return [self._frame(0x0B, struct.pack("<II", 3, 1)), self._frame(0x07, struct.pack("<I", 8))]

    def load(self, table: RippleTable) -> None:
        _, text = MAKES["odrive"].written(self._axis, table.torque_nm)
        for place, torque_nm in enumerate(json.loads(text)["cogging_map"]):
            self.drive.set_anticogging_value(place, torque_nm)
        self.drive.anticogging_enabled = True

    def go(self, turns: float, turns_s: float, torque_nm: float) -> list[CanFrame]:
        beside = turns_s * self.drive.input_vel_scale, torque_nm * self.drive.input_torque_scale
        held = [max(-32768, min(32767, round(value))) for value in beside]
        return [self._frame(0x0C, struct.pack("<fhh", turns, *held))]

    def _frame(self, command: int, data: bytes) -> CanFrame:
        return CanFrame(self.drive.number << 5 | command, data)


class Cia402Player:
    """Cyclic synchronous position, velocity offset and torque offset in two PDOs; the host keeps the table."""

    def __init__(self, axis: DriveOfAxis, inertia: float, bandwidth: float) -> None:
        self._counts, self._per_nm = MAKES["cia402"].units(axis)
        self._axis = axis
        self._table: np.ndarray | None = None
        self.drive = SimulatedCia402(axis.section.id, 1e3 / self._per_nm, self._counts)
        self.drive.gains = PositionGains(0.5 * bandwidth, 3.0 * inertia * bandwidth, inertia * bandwidth**2)

    def begin(self) -> list[CanFrame]:
        number = self.drive.number
        writes: list[tuple[int, int, int, int]] = []
        for at, objects in enumerate(((0x60400010, 0x607A0020, 0x60B20010), (0x60B10020,))):
            identifier = (0x200, 0x300)[at] + number
            # CiA 301: a mapping is changed of a PDO that is switched off, and counts its entries once they are there
            writes += [(0x1400 + at, 1, 4, 0x8000_0000 | identifier), (0x1600 + at, 0, 1, 0)]
            writes += [(0x1600 + at, place, 4, one) for place, one in enumerate(objects, 1)]
            writes += [(0x1600 + at, 0, 1, len(objects)), (0x1400 + at, 1, 4, identifier)]
        writes.append((0x6060, 0, 1, 8))
        sizes = {1: 0x2F, 2: 0x2B, 4: 0x23}
        frames = [CanFrame(0x600 + number, struct.pack("<BHBI", sizes[n], i, sub, v)) for i, sub, n, v in writes]
        frames.append(CanFrame(0x000, bytes([1, number])))
        for word in (0x06, 0x07, 0x0F):
            frames.append(CanFrame(0x200 + number, struct.pack("<Hih", word, self._at(0.0), 0)))
        return frames

    def load(self, table: RippleTable) -> None:
        self._table = table.torque_nm

    def go(self, turns: float, turns_s: float, torque_nm: float) -> list[CanFrame]:
        if self._table is not None:
            motor = self._axis.motor
            place = (turns * motor.rotor_turns + motor.rotor_zero) % 1.0 * len(self._table)
            left = int(place) % len(self._table)
            low, high = self._table[left], self._table[(left + 1) % len(self._table)]
            torque_nm += (low + (high - low) * (place - int(place))) * self._axis.shaft_per_joint
        offset = max(-32768, min(32767, round(torque_nm * self._per_nm)))
        number = self.drive.number
        return [
            CanFrame(0x300 + number, struct.pack("<i", self._at(turns_s))),
            CanFrame(0x200 + number, struct.pack("<Hih", 0x0F, self._at(turns), offset)),
        ]

    def _at(self, turns: float) -> int:
        return round(turns * self._counts)


#: link.drive -> (axis, inertia at the shaft in kg m^2, bandwidth in rad/s) -> its player
PLAYERS: dict[str, Callable[[DriveOfAxis, float, float], Player]] = {
    "moteus": MoteusPlayer,
    "odrive": OdrivePlayer,
    "cia402": Cia402Player,
}
