"""Dynamic unbalance: products of inertia of a body, which couple its rates into torque."""

from __future__ import annotations

from sim_backend.effects.axis_scale import AxisScale, Need
from sim_backend.effects.effect import Domain, Effect, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import Knob, SearchProfile, plane
from sim_backend.effects.separating_runs import ONE_LOCKED


def _search(scale: AxisScale) -> SearchProfile:
    """Products of inertia are small beside the moment that they tilt."""
    return SearchProfile(tuple(Knob((p,), size=0.02 * scale.own_inertia) for p in ("ixy", "ixz", "iyz")), (plane(3),))


EFFECT = Effect(
    name="dynamic_unbalance",
    domain=Domain.MASS,
    parameters=(
        Parameter(
            "ixy", "kg m2", -1e6, 1e6, 0.0, "product of inertia as it stands in the tensor", path="body.inertia.xy"
        ),
        Parameter(
            "ixz", "kg m2", -1e6, 1e6, 0.0, "product of inertia as it stands in the tensor", path="body.inertia.xz"
        ),
        Parameter(
            "iyz", "kg m2", -1e6, 1e6, 0.0, "product of inertia as it stands in the tensor", path="body.inertia.yz"
        ),
    ),
    text="products of inertia of a body",
    equation="terms with I_xy, I_xz, I_yz in d/dt(I w)",
    source="thesis sec. 3.2.1",
    excited_by="a moving base, or both axes at speed",
    two_axis_only=True,
    search=_search,
    acts_through=frozenset({Variable.POSITION, Variable.RATE, Variable.ACCELERATION, Variable.BASE_MOTION}),
    needs=Need.MOVING_BASE,
    separated_by=(ONE_LOCKED,),
)
