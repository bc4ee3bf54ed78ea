"""Linear predictive control of one joint: the quadratic program whose first move is the acceleration asked for.

States are how far the joint is behind its reference (rad) and how fast that grows (rad/s), moves are accelerations
beyond the reference's (rad/s^2). The first ones are held for a tick, later ones longer, so that few of them reach far.
The weights are those of `rivals.regulator`, the cost beyond the horizon is that regulator's, and torque and rate stay
within limits (Rawlings, Mayne and Diehl 2017, chapter 2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_discrete_are

Matrix = NDArray[np.float64]
#: ticks for which each move is held: a quarter of a second at 1 kHz
HELD_TICKS = (1, 1, 2, 3, 5, 8, 13, 21, 34, 55, 89)


@dataclass(frozen=True, eq=False)
class PredictedJoint:
    """The program of one joint: over moves u minimise u' H u / 2 + (F x)' u for a state x."""

    #: H (n, n), F (n, 2), in units of a move's own weight over a tick
    hessian: Matrix
    of_state: Matrix
    #: what each move adds to the joint's rate by the end of each (n, n), s
    to_rate: Matrix


def predicted_joint(natural_rad_s: float, step_s: float, held_ticks: tuple[int, ...] = HELD_TICKS) -> PredictedJoint:
    """The program of weights one on the position and natural^-4 on the acceleration."""
    A, B = np.array([[1.0, step_s], [0.0, 1.0]]), np.array([[-0.5 * step_s**2], [-step_s]])
    Q, R = np.diag([natural_rad_s**4, 0.0]), np.eye(1)
    n = len(held_ticks)
    # state of each tick from the first one and the moves
    reached = np.hstack([np.eye(2), np.zeros((2, n))])
    cost, to_rate = np.zeros((2 + n, 2 + n)), np.zeros((n, n))
    for move, ticks in enumerate(held_ticks):
        chosen = np.zeros((1, 2 + n))
        chosen[0, 2 + move] = 1.0
        for _ in range(ticks):
            cost += reached.T @ Q @ reached + chosen.T @ R @ chosen
            reached = A @ reached + B @ chosen
        to_rate[move] = -reached[1, 2:]
    cost += reached.T @ solve_discrete_are(A, B, Q, R) @ reached
    return PredictedJoint(cost[2:, 2:], cost[2:, :2], to_rate)


def natural_of(position_kp: float, crossing: float) -> float:
    """Natural frequency (rad/s) of a double integrator under these two gains (1/s, rad/s)."""
    return float(np.sqrt(position_kp * crossing))
