"""Bristles: stiffness and damping of the joint before it breaks away."""

from __future__ import annotations

from sim_backend.effects.effect import Domain, Effect, Parameter

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
)
