"""Inertia: the moment of a body about its own axis (the mass of a linear axis)."""

from __future__ import annotations

from sim_backend.effects.effect import Domain, Effect, Parameter

EFFECT = Effect(
    name="inertia",
    domain=Domain.MASS,
    parameters=(
        Parameter("inertia", "kg m2", 1e-9, 1e9, 1.0, "moment about the joint's own axis", linear_unit="kg", path="body.own_inertia"),
    ),
    text="moment of the body about its own axis",
    equation="J q'' = T - F + ...",
    source="thesis eq. 2.55",
    excited_by="accelerations: steps, trapezoids, chirps",
)
