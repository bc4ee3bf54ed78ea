"""Torque offset: the drive delivers torque at zero command."""

from __future__ import annotations

from sim_backend.effects.effect import Domain, Effect, Parameter

EFFECT = Effect(
    name="torque_offset",
    domain=Domain.DRIVE,
    parameters=(Parameter("offset", "N m", -1e5, 1e5, 0.0, "o in T = u + o", linear_unit="N", path="actuator.offset"),),
    text="torque at zero command",
    equation="T = u + o",
    source="offset of the current sensor; SOURCE.md of the EMPS data shows a drifting one",
    excited_by="constant speeds in both directions at several positions",
)
