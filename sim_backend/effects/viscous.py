"""Viscous friction: the model's sigma2 being wrong."""

from __future__ import annotations

from sim_backend.effects.effect import Domain, Effect, Parameter

EFFECT = Effect(
    name="viscous",
    domain=Domain.FRICTION,
    parameters=(
        Parameter("viscous", "N m s/rad", 0.0, 1e6, 0.0, "sigma2, friction per joint rate", linear_unit="N s/m", path="friction.viscous"),
    ),
    text="viscous friction of the joint",
    equation="F = ... + sigma2 v",
    source="thesis eq. 4.1",
    excited_by="constant speeds over a decade, both directions",
)
