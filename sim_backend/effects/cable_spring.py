"""Cable wrap: cables and hoses that pull the joint back to a rest position, with a friction of their own.

The optional hysteresis is Dahl's: the cable's internal friction builds up to its level over an angle and is carried
from one reversal to the next. Its bristle equation at constant rate is linear, so each step is exact at any rate.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects.axis_scale import AxisScale
from sim_backend.effects.effect import Domain, Effect, Hook, PlainerEffect, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import Knob, Reading, SearchProfile, Start
from sim_backend.effects.separating_runs import FULL_TRAVEL, TWO_LOADS, TWO_TILTS
from sim_backend.friction import decay_half

STIFFNESS, REST_POSITION, HYSTERESIS, HYSTERESIS_ANGLE = range(4)
INTERNAL_FRICTION = 0


@compiled
def cable_torque(P: np.ndarray, o: int, X: np.ndarray, s: int, q: float, v: float, h: float) -> float:
    """-k (q - q0) - w, N m, with w the mean over the step of the cable's internal friction."""
    spring = -P[o + STIFFNESS] * (q - P[o + REST_POSITION])
    if P[o + HYSTERESIS] == 0.0 or v == 0.0:
        return spring - X[s + INTERNAL_FRICTION]
    settled = P[o + HYSTERESIS] if v > 0.0 else -P[o + HYSTERESIS]
    turned = abs(v) * h / P[o + HYSTERESIS_ANGLE]
    left = X[s + INTERNAL_FRICTION] - settled
    share = 1.0 - turned * decay_half(turned)
    X[s + INTERNAL_FRICTION] = settled + left * (1.0 - turned * share)
    return spring - settled - left * share


def _search(scale: AxisScale) -> SearchProfile:
    """The rest position acts through stiffness times angle: at a probe of one unit its response is the constant torque
    k q0.
    """
    knobs = (
        Knob(("stiffness",), size=0.1 * scale.torque_rms / max(scale.travel, 1e-9), low=0.0),
        Knob(("rest_position",), low=-50.0, high=50.0),
    )
    return SearchProfile(knobs, (Start(((1.0, 0.0), (1.0, 1.0)), (0.0, 0.0), Reading.SPRING),))


def _over_travel(values: Mapping[str, float], breakaway: float, travel: float) -> float:
    """The pull from one end of the travel to the other, N m."""
    return abs(values["stiffness"]) * travel


EFFECT = Effect(
    name="cable_spring",
    domain=Domain.STRUCTURE,
    hook=Hook.TORQUE,
    law=cable_torque,
    states=1,
    parameters=(
        Parameter("stiffness", "N m/rad", 0.0, 1e6, 0.0, "pull per angle from the rest position", linear_unit="N/m"),
        Parameter("rest_position", "rad", -100.0, 100.0, 0.0, "q0, where the cable does not pull", linear_unit="m"),
        Parameter(
            "hysteresis",
            "N m",
            0.0,
            1e5,
            0.0,
            "half the width of the cable's own friction loop; 0 means none",
            linear_unit="N",
        ),
        Parameter(
            "hysteresis_angle", "rad", 1e-6, 10.0, 0.05, "angle over which that friction builds up", linear_unit="m"
        ),
    ),
    text="cable wrap pulls back to a rest position",
    equation="T - k (q - q0), optionally - w with w' = (W v - abs(v) w) / angle",
    source="Dahl, A solid friction model, Aerospace Corp. TOR-0158 (1968)",
    excited_by="slow motion over the whole travel in both directions",
    search=_search,
    acts_through=frozenset({Variable.POSITION}),
    separated_by=(FULL_TRAVEL, TWO_TILTS, TWO_LOADS),
    torque_over_position=_over_travel,
    # k q0 alone is a constant torque
    plainer=PlainerEffect("torque_offset"),
)
