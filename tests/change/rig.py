"""A joint of a bench, stepped by itself: bristle friction, a ripple, a spring, a drive's gain; a PD loop follows sums
of sines that no two logs share.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from gimbal_hil.data.signals import SignalsTable
from sim_backend.model import AntennaModel, model_from_document

STEP_S, EVERY, COUNT_RAD, BRISTLE = 2e-4, 10, 9.6e-5, 100.0


@dataclass(frozen=True)
class Machine:
    """Numbers of one machine, SI; `order` a turn."""

    inertia: float = 0.02
    coulomb: float = 0.05
    viscous: float = 0.02
    ripple: float = 0.0
    order: float = 7.0
    spring: float = 0.0
    gain: float = 1.0

    def log(self, random: np.random.Generator, seconds: float = 30.0) -> SignalsTable:
        """A log of its own trajectory, 500 Hz."""
        t = np.arange(int(seconds / STEP_S)) * STEP_S
        swings = [
            (random.uniform(0.8, 1.4), random.uniform(0.08, 0.2)),
            (random.uniform(0.3, 0.7), random.uniform(0.25, 0.5)),
        ]
        phases = random.uniform(0.0, 2.0 * np.pi, 2)
        wanted = np.clip(t, 0.0, 1.0) ** 2 * sum(
            size * (np.sin(2.0 * np.pi * hertz * t + phase) - np.sin(phase))
            for (size, hertz), phase in zip(swings, phases, strict=True)
        )
        numbers = (self.inertia, self.coulomb, self.viscous, self.ripple, self.order, self.spring, self.gain)
        position, torque = _stepped(wanted, np.gradient(wanted, STEP_S), *numbers)
        time_s = np.arange(len(position)) * STEP_S * EVERY
        return SignalsTable.of(("joint",), time_s, {"joint.torque": torque, "joint.position": position}, source="log")

    def logs(self, random: np.random.Generator, count: int = 2) -> tuple[SignalsTable, ...]:
        """Several."""
        return tuple(self.log(random) for _ in range(count))

    def but(self, **changed: float) -> Machine:
        """The same machine with other numbers."""
        return replace(self, **changed)

    def model(self) -> AntennaModel:
        """A model that has these numbers, and neither ripple, spring nor gain."""
        levels = {name: {"value": self.coulomb, "unit": "N m"} for name in ("coulomb", "breakaway")}
        friction = levels | {
            "stribeck_velocity": {"value": 0.01, "unit": "rad/s"},
            "shape": {"value": 1.0, "unit": "1"},
            "sigma0": {"value": BRISTLE, "unit": "N m/rad"},
            "sigma1": {"value": 0.1, "unit": "N m s/rad"},
            "viscous": {"value": self.viscous, "unit": "N m s/rad"},
        }
        axis = {
            "body": {"inertia": {"zz": {"value": self.inertia, "unit": "kg m2"}}},
            "friction": friction,
            "actuator": {"limit": {"value": 3.0, "unit": "N m"}},
            "encoder": {"step": {"value": COUNT_RAD, "unit": "rad"}},
        }
        return model_from_document({"schema": 1, "name": "bench", "kind": "rotary", "axes": {"joint": axis}}, "bench")


@njit(cache=True)
def _stepped(
    wanted: np.ndarray,
    slope: np.ndarray,
    inertia: float,
    coulomb: float,
    viscous: float,
    ripple: float,
    order: float,
    spring: float,
    gain: float,
) -> tuple[np.ndarray, np.ndarray]:
    q = v = z = torque = 0.0
    rows = len(wanted) // EVERY
    shown, commanded = np.zeros(rows), np.zeros(rows)
    for k in range(rows * EVERY):
        if k % EVERY == 0:
            torque = 6.0 * (wanted[k] - q) + 0.5 * (slope[k] - v) + 0.06 * np.tanh(slope[k] / 0.02)
            torque = np.round(torque * 1e4) / 1e4
            shown[k // EVERY] = np.round(q / COUNT_RAD) * COUNT_RAD
            commanded[k // EVERY] = torque
        # the bristle's own equation, solved for a step of constant rate: it is stiff at speed
        bent = np.sign(v) * coulomb / BRISTLE
        after = bent + (z - bent) * np.exp(-abs(v) * BRISTLE / coulomb * STEP_S)
        bending, z = (after - z) / STEP_S, after
        friction = BRISTLE * z + 0.1 * bending + viscous * v
        v += STEP_S * (gain * torque + ripple * np.sin(order * q + 0.4) - spring * q - friction) / inertia
        q += STEP_S * v
    return shown, commanded
