"""Viscous friction: the model's sigma2 being wrong."""

from __future__ import annotations

from sim_backend.effects.axis_scale import AxisScale
from sim_backend.effects.effect import Domain, Effect, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import SearchProfile, one_knob
from sim_backend.effects.separating_runs import MEASURED_TORQUE, PLATEAUS, WARM_AND_COOL


def _search(scale: AxisScale) -> SearchProfile:
    """A fifth of what the model states, or of a share of the torque at speed where it states next to none."""
    return one_knob("viscous", 0.2 * scale.drag)


EFFECT = Effect(
    name="viscous",
    domain=Domain.FRICTION,
    parameters=(
        Parameter(
            "viscous",
            "N m s/rad",
            0.0,
            1e6,
            0.0,
            "sigma2, friction per joint rate",
            linear_unit="N s/m",
            path="friction.viscous",
        ),
    ),
    text="viscous friction of the joint",
    equation="F = ... + sigma2 v",
    source="thesis eq. 4.1",
    excited_by="constant speeds over a decade, both directions",
    search=_search,
    acts_through=frozenset({Variable.RATE}),
    separated_by=(PLATEAUS, WARM_AND_COOL, MEASURED_TORQUE),
    same_by_command="back_emf",
    asked_as="viscosity",
    must_show=True,
)
