"""Stribeck bump: how high it is, at what speed it fades, and how sharply."""

from __future__ import annotations

import math
from collections.abc import Mapping

from sim_backend.effects.axis_scale import AxisScale, Need
from sim_backend.effects.effect import Domain, Effect, FittedNumber, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import Knob, Move, SearchProfile, Start, plane
from sim_backend.effects.separating_runs import CREEP

#: the bump's speed is sought between exp of these times what the model has
_SPEEDS = (-3.5, 3.5)


def _search(scale: AxisScale) -> SearchProfile:
    """From the bump as the model has it, and from bumps that fade at other speeds, where only their height is
    proportional.

    No bump fades at a speed below which the model states no friction: how a joint comes to rest would take its name.
    """
    stated = scale.numbers["friction.stribeck_velocity"]
    # where the model's own bump is such a one, the search begins at the slowest that it may find
    begins = max(stated, scale.least_stated_speed)
    slowest = max(_SPEEDS[0], math.log(scale.least_stated_speed / begins)) if scale.least_stated_speed else _SPEEDS[0]
    knobs = (
        Knob(("breakaway",), size=0.1 * max(scale.numbers["friction.breakaway"], 1e-9)),
        Knob(("stribeck_velocity",), Move.LEVEL if begins > stated else Move.FACTOR, begins, slowest, _SPEEDS[1]),
        # how sharply it fades shows between two or three speeds only
        Knob(("shape",), Move.FACTOR, 1.0, -0.7, 1.2, nuisance=True),
    )
    shifts = (shift for shift in (-0.7, 0.7, 1.4, 2.1, 3.0) if shift >= slowest)
    elsewhere = (Start(((0.7, shift, 0.0),), (0.0, shift, 0.0)) for shift in shifts)
    return SearchProfile(knobs, (plane(3, 0.3), *elsewhere))


def _against_a_bump(fitted: Mapping[str, FittedNumber]) -> str:
    """Friction that falls towards standstill is no bump, whatever the curve's numbers: the model states Ts at Tc or
    above.
    """
    breakaway = fitted.get("breakaway")
    if breakaway is None or breakaway.nominal is None or breakaway.high >= breakaway.nominal:
        return ""
    return (
        f"The data contradict a Stribeck bump: friction falls towards standstill, break-away {breakaway.value:.3g}"
        f" {breakaway.unit} lies below Coulomb friction {breakaway.nominal:.3g}; do not read the number as a "
        "break-away torque."
    )


EFFECT = Effect(
    name="stribeck",
    domain=Domain.FRICTION,
    parameters=(
        Parameter(
            "breakaway", "N m", 0.0, 1e6, 0.0, "Ts, torque at break-away", linear_unit="N", path="friction.breakaway"
        ),
        Parameter(
            "stribeck_velocity",
            "rad/s",
            1e-6,
            100.0,
            0.01,
            "v_s, where the bump has fallen to 37 %",
            linear_unit="m/s",
            path="friction.stribeck_velocity",
        ),
        Parameter("shape", "1", 0.2, 10.0, 1.0, "delta, exponent of the curve", path="friction.shape"),
    ),
    text="bump of the friction curve at low speed",
    equation="(Ts - Tc) exp(-(abs(v)/v_s)^delta)",
    source="thesis eq. 4.2 as corrected; Armstrong-Helouvry et al., Automatica 30 (1994)",
    excited_by="constant speeds below, at and above v_s, both directions",
    search=_search,
    needs=Need.SLIDING,
    acts_through=frozenset({Variable.RATE}),
    separated_by=(CREEP,),
    objection=_against_a_bump,
)
