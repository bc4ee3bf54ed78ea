"""Coulomb friction: the whole Stribeck curve moved up or down, Tc and Ts by the same amount."""

from __future__ import annotations

from sim_backend.effects.axis_scale import AxisScale, Need
from sim_backend.effects.effect import Domain, Effect, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import Knob, SearchProfile, line
from sim_backend.effects.separating_runs import CREEP, PLATEAUS, TWO_LOADS, WARM_AND_COOL


def _search(scale: AxisScale) -> SearchProfile:
    """Both levels move together: the bump on top of them is the Stribeck effect's."""
    return SearchProfile((Knob(("coulomb", "breakaway"), size=0.1 * scale.friction),), (line(),))


EFFECT = Effect(
    name="coulomb",
    domain=Domain.FRICTION,
    parameters=(
        Parameter(
            "coulomb",
            "N m",
            0.0,
            1e6,
            0.0,
            "Tc, sliding torque without the Stribeck bump",
            linear_unit="N",
            path="friction.coulomb",
        ),
        Parameter(
            "breakaway", "N m", 0.0, 1e6, 0.0, "Ts, torque at break-away", linear_unit="N", path="friction.breakaway"
        ),
    ),
    text="level of the sliding friction",
    equation="s(v) = Tc + (Ts - Tc) exp(-(abs(v)/v_s)^delta), Tc and Ts moved together",
    source="thesis eq. 4.1 and 4.2 as corrected",
    excited_by="constant speeds in both directions; any motion that reverses",
    search=_search,
    needs=Need.SLIDING,
    acts_through=frozenset({Variable.RATE}),
    separated_by=(PLATEAUS, CREEP, WARM_AND_COOL, TWO_LOADS),
    asked_as="Coulomb friction",
    must_show=True,
)
