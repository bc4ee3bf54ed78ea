"""Static unbalance: the centre of mass of a body is not where the model has it."""

from __future__ import annotations

from sim_backend.effects.effect import Domain, Effect, Parameter

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
    source="thesis sec. 3.3; ERRATA eq. 2.52: separate bodies",
    excited_by="a full turn of a tilted axis, or two base tilts",
    rotary_only=True,
)
