"""Static unbalance: the centre of mass of a body is not where the model has it."""

from __future__ import annotations

from sim_backend.effects.axis_scale import AxisScale
from sim_backend.effects.effect import Domain, Effect, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import Knob, SearchProfile, plane
from sim_backend.effects.separating_runs import FULL_TRAVEL, KNOWN_LOAD, ONE_LOCKED, TWO_LOADS, TWO_TILTS

#: m/s^2 (a size to count in need be no more exact), and the largest step of a centre of mass, m
_GRAVITY, _FARTHEST_M = 9.8, 1.0


def _search(scale: AxisScale) -> SearchProfile | None:
    """A tenth of the distance that the model states, or as far as a twentieth of the torque holds it; a body without
    mass weighs nothing wherever its centre is.
    """
    mass = scale.numbers["body.mass"]
    if mass <= 0.0:
        return None
    size = max(0.1 * scale.cog_distance, min(0.05 * scale.torque_rms / (mass * _GRAVITY), _FARTHEST_M))
    return SearchProfile(tuple(Knob((f"cog_{c}",), size=size) for c in "xyz"), (plane(3),))


EFFECT = Effect(
    name="static_unbalance",
    domain=Domain.MASS,
    parameters=(
        Parameter("cog_x", "m", -10.0, 10.0, 0.0, "centre of mass from the pivot", path="body.cog.x"),
        Parameter("cog_y", "m", -10.0, 10.0, 0.0, "centre of mass from the pivot", path="body.cog.y"),
        Parameter("cog_z", "m", -10.0, 10.0, 0.0, "centre of mass from the pivot", path="body.cog.z"),
    ),
    text="centre of mass off the pivot",
    equation="r x m g",
    source="thesis sec. 3.3, eq. 2.52 as corrected in docs/explanation/reading-the-thesis.md: separate bodies",
    excited_by="a full turn of a tilted axis, or two base tilts",
    rotary_only=True,
    search=_search,
    acts_through=frozenset({Variable.POSITION, Variable.ATTITUDE}),
    separated_by=(FULL_TRAVEL, TWO_TILTS, KNOWN_LOAD, TWO_LOADS, ONE_LOCKED),
)
