"""Gyro misalignment: a gyro mounted askew reads a part of the body's two other rates."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects.axis_scale import AxisScale, Need
from sim_backend.effects.effect import Domain, Effect, Hook, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import Knob, SearchProfile, plane
from sim_backend.effects.separating_runs import ONE_LOCKED
from sim_backend.layout import INNER

LEAK_X, LEAK_Y, LEAK_Z = range(3)


@compiled
def leaked_rate(P: np.ndarray, o: int, X: np.ndarray, s: int, axis: int, wx: float, wy: float, wz: float) -> float:
    """Rate (rad/s) added to the gyro: the outer one reads z and leaks x and y, the inner one reads y and leaks x and
    z.
    """
    if axis == INNER:
        return P[o + LEAK_X] * wx + P[o + LEAK_Z] * wz
    return P[o + LEAK_X] * wx + P[o + LEAK_Y] * wy


def _search(scale: AxisScale) -> SearchProfile:
    """Leaks of the two rates that are not the gyro's own; a hundredth is 0.6 degrees of mounting."""
    leaks = ("leak_x", "leak_z") if scale.axis_index == INNER else ("leak_x", "leak_y")
    return SearchProfile(tuple(Knob((p,), size=0.01, low=-45.0, high=45.0) for p in leaks), (plane(2),))


EFFECT = Effect(
    name="gyro_misalignment",
    domain=Domain.SENSOR,
    hook=Hook.GYRO,
    law=leaked_rate,
    parameters=(
        Parameter("leak_x", "1", -0.5, 0.5, 0.0, "part of the body's x rate"),
        Parameter(
            "leak_y", "1", -0.5, 0.5, 0.0, "part of the body's y rate; the inner gyro's own, without effect there"
        ),
        Parameter(
            "leak_z", "1", -0.5, 0.5, 0.0, "part of the body's z rate; the outer gyro's own, without effect there"
        ),
    ),
    text="a gyro reads part of the other rates",
    equation="rate + a part of the body's two other rates",
    source="IEEE Std 952; thesis eq. 2.9 and 2.10 for the rates",
    excited_by="one axis driven with the other at an angle, or a moving base",
    two_axis_only=True,
    search=_search,
    acts_through=frozenset({Variable.POSITION, Variable.RATE, Variable.BASE_MOTION}),
    needs=Need.GYRO | Need.MOVING_BASE,
    separated_by=(ONE_LOCKED,),
)
