"""Gains of the observer: the steady Kalman filter for stated noises, by iteration of its Riccati equation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.loop.control.layout import OBSERVER_STATES

Matrix = NDArray[np.float64]
#: states that encoder and gyro measure
MEASURED_STATES = (0, 4)
_MOST_ROUNDS, _SETTLED = 40_000, 1e-9


@dataclass(frozen=True)
class ObservedJoint:
    """What the gains of one joint's observer follow from."""

    step_s: float
    #: one standard deviation of a sample, rad and rad/s
    encoder_noise_rad: float
    gyro_noise_rad_s: float
    #: how fast disturbances are taken over: the poles of a filter that had the encoder only
    bandwidth_rad_s: float
    #: walk of the gyro's offset against joint and base rate, rad/s in a root second
    offset_walk_rad_s: float
    #: the gyro's lag over a tick (a11, a12, a21, a22, b1, b2); zeros for an ideal gyro
    gyro_lag: tuple[float, ...] = (0.0,) * 6
    #: above it disturbances are taken for gusts, of an even spectrum, below it for lasting ones; infinite: all last
    gusts_above_rad_s: float = math.inf

    def transition(self) -> Matrix:
        """States of the next tick from those of this one, (6, 6), without torque and base rate; order as in layout."""
        T = self.step_s
        A = np.zeros((OBSERVER_STATES, OBSERVER_STATES))
        A[0, :3], A[1, 1:3], A[2, 2], A[3, 3] = (1.0, T, 0.5 * T * T), (1.0, T), 1.0, 1.0
        a11, a12, a21, a22, b1, b2 = self.gyro_lag
        if a11 == 0.0:
            A[4, 1:4] = 1.0, T, 1.0
        else:
            turned = np.array([1.0, 0.5 * T, 1.0])
            A[4, 1:4], A[4, 4:6] = b1 * turned, (a11, a12)
            A[5, 1:4], A[5, 4:6] = b2 * turned, (a21, a22)
        return A

    def noises(self) -> tuple[Matrix, Matrix]:
        """Covariances of what moves the states in a tick (6, 6) and of a sample of encoder and gyro (2, 2).

        The spectrum of the disturbance's walk is the one for which three poles of an encoder's filter lie at the
        bandwidth on a Butterworth circle: encoder spectrum times bandwidth^6. Gusts move the rate itself, by as much as
        the walk has at their corner.
        """
        T, encoder = self.step_s, self.encoder_noise_rad**2
        Q = np.zeros((OBSERVER_STATES, OBSERVER_STATES))
        Q[2, 2] = encoder * T * self.bandwidth_rad_s**6 * T
        Q[1, 1] = Q[2, 2] / self.gusts_above_rad_s**2
        Q[3, 3] = self.offset_walk_rad_s**2 * T
        return Q, np.diag([encoder, self.gyro_noise_rad_s**2])

    def gains(self) -> Matrix:
        """Gains (6, 2) on the innovations of encoder and gyro."""
        A, (Q, R), rows = self.transition(), self.noises(), list(MEASURED_STATES)
        P: Matrix = np.diag([R[0, 0], 1e-4, 1.0, 1e-4, 1e-4, 1e-4])
        K: Matrix = np.zeros((OBSERVER_STATES, 2))
        before = K
        for number in range(_MOST_ROUNDS):
            P = np.asarray(A @ P @ A.T + Q)
            K = np.asarray(np.linalg.solve(P[np.ix_(rows, rows)] + R, P[rows]).T, dtype=np.float64)
            P = P - K @ P[rows]
            P = 0.5 * (P + P.T)
            if number % 64 == 0:
                if np.all(np.abs(K - before) <= _SETTLED * np.abs(K).max(axis=0)):
                    break
                before = K
        return K
