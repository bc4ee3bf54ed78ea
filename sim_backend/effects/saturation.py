"""Saturation: the drive delivers no more than a limit."""

from __future__ import annotations

from sim_backend.effects.effect import Domain, Effect, Parameter

EFFECT = Effect(
    name="saturation",
    domain=Domain.DRIVE,
    parameters=(Parameter("limit", "N m", 0.0, 1e9, 0.0, "largest torque; 0 means none", linear_unit="N", path="actuator.limit"),),
    text="torque limited below what is commanded",
    equation="T = min(max(u, -limit), limit)",
    source="ERRATA: what the controller tables imply",
    excited_by="commands beyond the limit: large steps",
)
