"""Gyro misalignment: a gyro mounted askew reads a part of the body's two other rates."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects.effect import Domain, Effect, Hook, Parameter
from sim_backend.layout import INNER

LEAK_X, LEAK_Y, LEAK_Z = range(3)


@compiled
def leaked_rate(P: np.ndarray, o: int, X: np.ndarray, s: int, axis: int, wx: float, wy: float, wz: float) -> float:
    """Rate (rad/s) added to the gyro: the outer one reads z and leaks x and y, the inner one reads y and leaks x and z."""
    if axis == INNER:
        return P[o + LEAK_X] * wx + P[o + LEAK_Z] * wz
    return P[o + LEAK_X] * wx + P[o + LEAK_Y] * wy


EFFECT = Effect(
    name="gyro_misalignment",
    domain=Domain.SENSOR,
    hook=Hook.GYRO,
    law=leaked_rate,
    parameters=(
        Parameter("leak_x", "1", -0.5, 0.5, 0.0, "part of the body's x rate"),
        Parameter("leak_y", "1", -0.5, 0.5, 0.0, "part of the body's y rate; the inner gyro's own, without effect there"),
        Parameter("leak_z", "1", -0.5, 0.5, 0.0, "part of the body's z rate; the outer gyro's own, without effect there"),
    ),
    text="a gyro reads part of the other rates",
    equation="rate + a part of the body's two other rates",
    source="CONTRACTS 6; IEEE Std 952; thesis eq. 2.9 and 2.10 for the rates",
    excited_by="one axis driven with the other at an angle, or a moving base",
    two_axis_only=True,
)
