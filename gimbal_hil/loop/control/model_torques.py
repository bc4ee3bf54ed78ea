"""Torques that a motion takes by the model: inertia, coupling of the axes, weight, a turning and accelerating base.

The equations are the virtual antenna's own (`sim_backend.rigid_body`), with the numbers of a model file, at the
reference in place of the measurement: nothing is fed back, so no margin changes.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import sine_cosine
from sim_backend.rigid_body import equations_at

Vector = tuple[float, float, float]
Pair = tuple[float, float]


@compiled
def rigid_torques(
    tensor: np.ndarray, body: np.ndarray, q: Pair, v: Pair, a: Pair, base: tuple[Vector, Vector, Vector]
) -> tuple[Pair, Pair]:
    """Torques (N m) beside inertia times acceleration, and the inertias (kg m^2), of both joints of a gimbal that is at
    q (rad), v (rad/s), a (rad/s^2).

    `base` is gravity less the pivot's acceleration (m/s^2), angular rate and angular acceleration, in base axes.
    `tensor` begins like the plant's parameters, up to the outer body's tensor; `body` has the numbers of
    `rigid_body.body_numbers`, in a row.
    """
    turns = (sine_cosine(q[0]), sine_cosine(q[1]))
    numbers = (
        (body[0], body[1], body[2]),
        (body[3], body[4], body[5]),
        (body[6], body[7], body[8]),
        (body[9], body[10], body[11]),
    )
    # the plant's structure, for which `body` stands in, is asked for a single axis only
    mass, bias, _, _, _ = equations_at(tensor, body, numbers, turns, v, base, True, True)
    return (mass[1] * a[1] - bias[0], mass[1] * a[0] - bias[1]), (mass[0], mass[2])
