"""Cogging: torque ripple of the motor's magnets against its slots, fixed to the joint position."""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import sine_cosine
from sim_backend.effects.effect import Domain, Effect, Hook, Parameter

AMPLITUDE, ORDER, PHASE = range(3)


@compiled
def cogging_torque(P: np.ndarray, o: int, X: np.ndarray, s: int, q: float, v: float, h: float) -> float:
    """A sin(n q + phase), N m."""
    return P[o + AMPLITUDE] * sine_cosine(P[o + ORDER] * q + P[o + PHASE])[0]


EFFECT = Effect(
    name="cogging",
    domain=Domain.DRIVE,
    hook=Hook.TORQUE,
    law=cogging_torque,
    parameters=(
        Parameter("amplitude", "N m", 0.0, 1e5, 0.0, "peak ripple torque", linear_unit="N"),
        Parameter("order", "1/turn", 1.0, 1e6, 1.0, "ripples per turn (per 2 pi m on a linear axis)"),
        Parameter("phase", "rad", -math.pi, math.pi, 0.0, "phase at zero position", periodic=True),
    ),
    text="torque ripple over position",
    equation="T + A sin(n q + phase)",
    source="CONTRACTS 6; Hanselman, Brushless Permanent Magnet Motor Design, ch. 5",
    excited_by="a slow constant speed over at least one ripple period",
)
