"""Torque gain: the drive delivers more or less torque than commanded."""

from __future__ import annotations

from sim_backend.effects.effect import Domain, Effect, Parameter

EFFECT = Effect(
    name="torque_gain",
    domain=Domain.DRIVE,
    parameters=(Parameter("gain_error", "1", -0.9, 5.0, 0.0, "e in T = (1 + e) u", path="actuator.gain_error"),),
    text="torque constant or scale of the drive",
    equation="T = (1 + e) u",
    source="motor torque constant; Krause et al., Analysis of Electric Machinery, ch. 2",
    excited_by="a known load: gravity, added inertia, or a stall run",
)
