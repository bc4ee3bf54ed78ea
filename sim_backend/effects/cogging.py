"""Cogging: torque ripple of the motor's magnets against its slots, fixed to the joint position."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import sine_cosine
from sim_backend.effects.axis_scale import AxisScale
from sim_backend.effects.effect import Domain, Effect, Hook, PlainerEffect, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import NEUTRAL_ORDER, Ripple, SearchProfile, ripple_profile
from sim_backend.effects.separating_runs import TWO_SPEEDS

AMPLITUDE, ORDER, PHASE = range(3)


@compiled
def cogging_torque(P: np.ndarray, o: int, X: np.ndarray, s: int, q: float, v: float, h: float) -> float:
    """A sin(n q + phase), N m."""
    return P[o + AMPLITUDE] * sine_cosine(P[o + ORDER] * q + P[o + PHASE])[0]


def _search(scale: AxisScale) -> SearchProfile:
    """Orders are read from what is left over position: magnets and slots have any number."""
    return ripple_profile("amplitude", 0.02 * scale.torque_rms, Ripple.TORQUE)


def _swing(values: Mapping[str, float], breakaway: float, travel: float) -> float:
    """Its peak, N m."""
    return abs(values["amplitude"])


EFFECT = Effect(
    name="cogging",
    domain=Domain.DRIVE,
    hook=Hook.TORQUE,
    law=cogging_torque,
    parameters=(
        Parameter("amplitude", "N m", 0.0, 1e5, 0.0, "peak ripple torque", linear_unit="N"),
        Parameter("order", "1/turn", 1.0, 1e6, NEUTRAL_ORDER, "ripples per turn (per 2 pi m on a linear axis)"),
        Parameter(
            "phase", "rad", -math.pi, math.pi, 0.0, "phase at zero position", periodic=True, half_turn_of="amplitude"
        ),
    ),
    text="torque ripple over position",
    equation="T + A sin(n q + phase)",
    source="Hanselman, Brushless Permanent Magnet Motor Design, ch. 5",
    excited_by="a slow constant speed over at least one ripple period",
    search=_search,
    acts_through=frozenset({Variable.POSITION}),
    separated_by=(TWO_SPEEDS,),
    # once a turn is what a centre of mass off the pivot does
    plainer=PlainerEffect("static_unbalance", (("order", 0.9, 1.1),)),
    torque_over_position=_swing,
)
