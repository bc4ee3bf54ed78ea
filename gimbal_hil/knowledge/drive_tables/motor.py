"""Conversion of turns and torques between a drive and its joint."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from firmware_protocol.links import DriveSection

_TURN = 2.0 * math.pi


@dataclass(frozen=True)
class Motor:
    """What no model tells of a motor: its torque constant (N m at the rotor for an A of q current, as the drive reckons
    it), and how the encoder by which the drive finds its place in a table reads: `rotor_turns` for one turn of the
    drive's shaft, negative where it counts backwards, and `rotor_zero` (turns) where the drive's position is zero.
    """

    torque_constant: float | None = None
    rotor_turns: float = 1.0
    rotor_zero: float = 0.0


@dataclass(frozen=True)
class DriveOfAxis:
    """One axis behind its drive."""

    axis: str
    section: DriveSection
    motor: Motor = Motor()

    def joint_at_rotor(self, turns: np.ndarray) -> np.ndarray:
        """Joint positions (rad) at which the rotor's encoder reads these turns, beginning about the drive's zero."""
        shaft = (turns - self.motor.rotor_zero) / self.motor.rotor_turns
        return self.section.zero_rad + self.section.sign * _TURN * shaft / self.section.gear

    def shaft_turns(self, joint: float) -> float:
        """Turns of the shaft from the drive's zero at a joint position (rad)."""
        return self.section.sign * self.section.gear * (joint - self.section.zero_rad) / _TURN

    def shaft_turns_s(self, rate: float) -> float:
        """The shaft's turns/s at a joint rate (rad/s)."""
        return self.section.sign * self.section.gear * rate / _TURN

    @property
    def shaft_per_joint(self) -> float:
        """Torque at the shaft, in its own sign, for one N m at the joint."""
        return self.section.sign / self.section.gear
