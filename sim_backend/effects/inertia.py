"""Inertia: the moment of a body about its own axis (the mass of a linear axis)."""

from __future__ import annotations

from sim_backend.effects.axis_scale import AxisScale
from sim_backend.effects.effect import Domain, Effect, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import SearchProfile, one_knob
from sim_backend.effects.separating_runs import KNOWN_LOAD, ONE_LOCKED, REVERSAL_SIZES, TORQUE_SWEEP, TWO_LOADS


def _search(scale: AxisScale) -> SearchProfile:
    """Torque is proportional to it: one probe of five per cent says it all."""
    return one_knob("inertia", 0.05 * scale.own_inertia)


EFFECT = Effect(
    name="inertia",
    domain=Domain.MASS,
    parameters=(
        Parameter(
            "inertia",
            "kg m2",
            1e-9,
            1e9,
            1.0,
            "moment about the joint's own axis",
            linear_unit="kg",
            path="body.own_inertia",
        ),
    ),
    text="moment of the body about its own axis",
    equation="J q'' = T - F + ...",
    source="thesis eq. 2.55",
    excited_by="accelerations: steps, trapezoids, chirps",
    search=_search,
    # on a moving base the base's own acceleration too
    acts_through=frozenset({Variable.ACCELERATION, Variable.BASE_MOTION}),
    separated_by=(KNOWN_LOAD, TORQUE_SWEEP, REVERSAL_SIZES, TWO_LOADS, ONE_LOCKED),
    asked_as="inertia",
    must_show=True,
)
