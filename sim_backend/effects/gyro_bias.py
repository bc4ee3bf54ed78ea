"""Gyro bias: the gyro reads a rate at rest."""

from __future__ import annotations

from sim_backend.effects.effect import Domain, Effect, Parameter

EFFECT = Effect(
    name="gyro_bias",
    domain=Domain.SENSOR,
    parameters=(Parameter("bias", "rad/s", -10.0, 10.0, 0.0, "added to the rate", linear_unit="m/s", path="gyro.bias"),),
    text="rate read at rest",
    equation="rate + b",
    source="IEEE Std 952",
    excited_by="any run with encoder and gyro, standing still included",
)
