"""One linear axis with true static friction, stepped in impulses: what a model without bristles is written for.

It shares nothing with the plant of this project: time stepping after Moreau, its own loop, its own motion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gimbal_hil.data.signals import SignalsTable
from sim_backend.model import AntennaModel, model_from_document

AXIS = "slide"
PERIOD_S, _SUBSTEPS = 2e-3, 10
_STEP_M = 1e-7


@dataclass(frozen=True)
class Rig:
    """Mass (kg), Coulomb (N) and viscous (N s/m) friction, and what no model of it has: offset (N), spring (N/m), screw
    ripple (N, m).
    """

    mass: float = 2.0
    coulomb: float = 1.2
    viscous: float = 6.0
    offset: float = 0.0
    spring: float = 0.0
    ripple: float = 0.0
    lead: float = 2.5e-3


def model(uncertainty: str = "2%") -> AntennaModel:
    """What the rig's maker knows of it, and how well."""
    known = Rig()
    friction = {
        "coulomb": known.coulomb,
        "breakaway": known.coulomb,
        "stribeck_velocity": 0.004,
        "viscous": known.viscous,
    }
    axis = {
        "body": {"mass": known.mass},
        "friction": friction,
        "actuator": {"limit": 60.0},
        "encoder": {"step": _STEP_M},
    }
    return model_from_document(
        {"schema": 1, "uncertainty": uncertainty, "name": "stage", "kind": "linear", "axes": {AXIS: axis}}, "static rig"
    )


def laps(t: float) -> float:
    """There and back, with a little of everything, m."""
    return 0.2 * math.sin(0.9 * t) + 0.05 * math.sin(3.1 * t) + 0.01 * math.sin(8.7 * t)


def sweep(t: float) -> float:
    """Faster and faster, m."""
    return 0.18 * math.sin(0.5 * t + 0.06 * t * t) + 0.02 * math.sin(5.3 * t)


def crawl(t: float) -> float:
    """Once there and half way back, m: slow enough for a screw's turns to pass inside the scored band."""
    return 0.2 * math.sin(0.17 * t) + 0.01 * math.sin(1.1 * t)


def log(rig: Rig, motion: str, seconds: float = 24.0, seed: int = 1) -> SignalsTable:
    """The rig's log of `laps`, `sweep` or `crawl`: commanded force and encoder position every 2 ms."""
    path = {"laps": laps, "sweep": sweep, "crawl": crawl}[motion]
    rng = np.random.default_rng(seed)
    n, h = int(seconds / PERIOD_S), PERIOD_S / _SUBSTEPS
    force, seen = np.zeros(n), np.zeros(n)
    position = rate = integral = smoothed = 0.0
    noise = 0.02 * rng.standard_normal(n)
    for k in range(n):
        t = k * PERIOD_S
        seen[k] = round(position / _STEP_M) * _STEP_M
        smoothed += 0.4 * ((seen[k] - seen[k - 1]) / PERIOD_S - smoothed) if k else 0.0
        wanted = 12.0 * (path(t) - seen[k]) + (path(t + 1e-4) - path(t - 1e-4)) / 2e-4
        integral += 600.0 * (wanted - smoothed) * PERIOD_S
        force[k] = 90.0 * (wanted - smoothed) + integral
        for _ in range(_SUBSTEPS):
            outside = (
                force[k]
                + noise[k]
                + rig.offset
                - rig.spring * position
                + rig.ripple * math.sin(2.0 * math.pi * position / rig.lead)
            )
            free = (rate + h * outside / rig.mass) / (1.0 + h * rig.viscous / rig.mass)
            rate = math.copysign(max(abs(free) - h * rig.coulomb / rig.mass, 0.0), free)
            position += h * rate
    return SignalsTable.of(
        (AXIS,), PERIOD_S * np.arange(n), {f"{AXIS}.torque": force, f"{AXIS}.position": seen}, source=motion
    )
