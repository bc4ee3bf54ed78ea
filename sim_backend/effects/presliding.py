"""Bristles: stiffness and damping of the joint before it breaks away."""

from __future__ import annotations

import math

import numpy as np

from sim_backend.effects.axis_scale import GIVES_M, GIVES_RAD, AxisScale
from sim_backend.effects.effect import Domain, Effect, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import Knob, Move, SearchProfile, plane, point
from sim_backend.effects.separating_runs import CREEP, REVERSAL_SIZES

#: deflections at break-away over which a bristle is sought where a model has none: travel at speed in these times, s
_QUICKLY_S, _SLOWLY_S = 5e-5, 0.15
#: factors between two starts, as logarithms
_APART = 1.0


def _search(scale: AxisScale) -> SearchProfile | None:
    """By factors, since nobody knows a bristle's order of magnitude.

    One for a model that has none turns over with the motion: within 0.05 to 150 ms of travel at speed, or up to as far
    as joints give way, where the data move that far.
    """
    if scale.numbers["friction.sigma0"] > 0.0:
        stiffness, damping = scale.numbers["friction.sigma0"], scale.numbers["friction.sigma1"]
        # sliding data say next to nothing about the damping
        knobs = (
            Knob(("sigma0",), Move.FACTOR, 1.0, -4.0, 4.0),
            Knob(("sigma1",), Move.FACTOR, 1.0, -4.0, 4.0, nuisance=True),
        )
        if damping == 0.0:
            knobs = (knobs[0], Knob(("sigma1",), size=0.1 * math.sqrt(stiffness * scale.own_inertia), nuisance=True))
        return SearchProfile(knobs, (plane(2, 0.1), point(1.0, 0.5), point(-1.0, -0.5)))
    if scale.numbers["friction.coulomb"] <= 0.0:
        return None
    longest = max(_SLOWLY_S * scale.speed, min(GIVES_M if scale.is_linear else GIVES_RAD, scale.travel))
    shortest = _QUICKLY_S * scale.speed
    knob = Knob(("sigma0",), Move.LEVEL, scale.numbers["friction.coulomb"] / longest, 0.0, math.log(longest / shortest))
    starts = np.arange(0.5 * _APART, knob.high, _APART)
    return SearchProfile((knob,), tuple(point(float(x)) for x in starts))


EFFECT = Effect(
    name="presliding",
    domain=Domain.FRICTION,
    parameters=(
        Parameter("sigma0", "N m/rad", 0.0, 1e12, 0.0, "bristle stiffness", linear_unit="N/m", path="friction.sigma0"),
        Parameter("sigma1", "N m s/rad", 0.0, 1e9, 0.0, "bristle damping", linear_unit="N s/m", path="friction.sigma1"),
    ),
    text="stiffness and damping before break-away",
    equation="F = sigma0 z + sigma1 z' + sigma2 v, z' = v - sigma0 abs(v) z / s(v)",
    source="Canudas de Wit et al., IEEE TAC 40 (1995)",
    excited_by="torque ramps and steps below break-away; reversals",
    search=_search,
    # before break-away friction goes with the way since the last reversal
    acts_through=frozenset({Variable.RATE, Variable.TORQUE, Variable.PAST}),
    unseen="the model has no bristle here, or the axis never stays below break-away",
    separated_by=(CREEP, REVERSAL_SIZES),
)
