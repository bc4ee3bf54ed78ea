"""Position-dependent friction: a bent shaft or a bearing that runs tighter on one side."""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import sine_cosine
from sim_backend.effects.effect import Domain, Effect, Hook, Parameter

RELATIVE_AMPLITUDE, ORDER, PHASE = range(3)


@compiled
def levels_over_position(
    P: np.ndarray, o: int, X: np.ndarray, s: int, q: float, v: float, torque: float, temperature: float, ts: float, tc: float, sigma2: float
) -> tuple[float, float, float]:
    """Ts and Tc times 1 + a cos(n q + phase), N m."""
    factor = 1.0 + P[o + RELATIVE_AMPLITUDE] * sine_cosine(P[o + ORDER] * q + P[o + PHASE])[1]
    return ts * factor, tc * factor, sigma2


EFFECT = Effect(
    name="position_dependent_friction",
    domain=Domain.FRICTION,
    hook=Hook.FRICTION,
    law=levels_over_position,
    parameters=(
        Parameter("relative_amplitude", "1", 0.0, 0.9, 0.0, "swing as a share of the mean friction"),
        Parameter("order", "1/turn", 1.0, 1e6, 1.0, "swings per turn (per 2 pi m on a linear axis)"),
        Parameter("phase", "rad", -math.pi, math.pi, 0.0, "phase at zero position", periodic=True),
    ),
    text="dry friction changes along the travel",
    equation="Tc, Ts times 1 + a cos(n q + phase)",
    source="CONTRACTS 6; Popovic and Goldenberg, Spectral analysis of friction, IEEE T-RA 14 (1998)",
    excited_by="slow constant speeds in both directions over at least one period",
)
