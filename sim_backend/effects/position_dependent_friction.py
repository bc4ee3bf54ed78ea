"""Position-dependent friction: a bent shaft or a bearing that runs tighter on one side."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import sine_cosine
from sim_backend.effects.axis_scale import AxisScale, Need
from sim_backend.effects.effect import Domain, Effect, Hook, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import NEUTRAL_ORDER, Ripple, SearchProfile, ripple_profile
from sim_backend.effects.separating_runs import TWO_LOADS, TWO_SPEEDS

RELATIVE_AMPLITUDE, ORDER, PHASE = range(3)


@compiled
def levels_over_position(
    P: np.ndarray,
    o: int,
    X: np.ndarray,
    s: int,
    q: float,
    v: float,
    torque: float,
    temperature: float,
    ts: float,
    tc: float,
    sigma2: float,
) -> tuple[float, float, float]:
    """Ts and Tc times 1 + a cos(n q + phase), N m."""
    factor = 1.0 + P[o + RELATIVE_AMPLITUDE] * sine_cosine(P[o + ORDER] * q + P[o + PHASE])[1]
    return ts * factor, tc * factor, sigma2


def _search(scale: AxisScale) -> SearchProfile:
    """Orders are read from what is left over position times the direction of motion."""
    return ripple_profile("relative_amplitude", 0.05, Ripple.FRICTION)


def _swing(values: Mapping[str, float], breakaway: float, travel: float) -> float:
    """Swing of the break-away torque, N m."""
    return abs(values["relative_amplitude"]) * breakaway


EFFECT = Effect(
    name="position_dependent_friction",
    domain=Domain.FRICTION,
    hook=Hook.FRICTION,
    law=levels_over_position,
    parameters=(
        Parameter("relative_amplitude", "1", 0.0, 0.9, 0.0, "swing as a share of the mean friction"),
        # a shaft that runs tighter on one side swings once a turn; half a swing keeps that off the bound of a search
        Parameter("order", "1/turn", 0.5, 1e6, NEUTRAL_ORDER, "swings per turn (per 2 pi m on a linear axis)"),
        Parameter(
            "phase",
            "rad",
            -math.pi,
            math.pi,
            0.0,
            "phase at zero position",
            periodic=True,
            half_turn_of="relative_amplitude",
        ),
    ),
    text="dry friction changes along the travel",
    equation="Tc, Ts times 1 + a cos(n q + phase)",
    source="Popovic and Goldenberg, Spectral analysis of friction, IEEE T-RA 14 (1998)",
    excited_by="slow constant speeds in both directions over at least one period",
    search=_search,
    needs=Need.SLIDING,
    acts_through=frozenset({Variable.POSITION, Variable.RATE}),
    separated_by=(TWO_SPEEDS, TWO_LOADS),
    torque_over_position=_swing,
)
