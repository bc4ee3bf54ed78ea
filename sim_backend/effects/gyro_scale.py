"""Gyro scale error: the gyro reads a rate in proportion too large or too small."""

from __future__ import annotations

from sim_backend.effects.effect import Domain, Effect, Parameter

EFFECT = Effect(
    name="gyro_scale",
    domain=Domain.SENSOR,
    parameters=(Parameter("scale_error", "1", -0.5, 0.5, 0.0, "s in (1 + s) rate", path="gyro.scale_error"),),
    text="scale factor error",
    equation="(1 + s) rate",
    source="IEEE Std 952",
    excited_by="constant speeds in both directions with encoder and gyro",
)
