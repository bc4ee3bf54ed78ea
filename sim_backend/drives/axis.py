"""What every simulated drive has: a shaft that moves, and a firmware that hears frames and answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from firmware_protocol.adapters import CanFrame


@dataclass
class Shaft:
    """Motion of a drive's shaft, in its own sign and turns of its own."""

    position_rad: float = 0.0
    rate_rad_s: float = 0.0
    torque_nm: float = 0.0


class SimulatedDrive(Protocol):
    """One drive; `shaft` is written by whoever moves it, `torque_nm` is what it applies now."""

    shaft: Shaft

    @property
    def torque_nm(self) -> float:
        """Torque at the shaft now: none where it is off, in fault, or out of time."""

    def hear(self, frame: CanFrame) -> list[CanFrame]:
        """Answers to one frame at once; none where it is for somebody else."""

    def tick(self, period_s: float) -> list[CanFrame]:
        """Time goes on: watchdogs count, and what is sent by itself is sent."""
