"""Whether a sampled law and an axis are stable together: the largest pole of both, tick by tick."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from gimbal_hil.knowledge.tuning.loops import AxisDynamics, CascadeLaw, Law, ObservedLaw, SampledLaw, torque_input

Matrix = NDArray[np.float64]


def largest_pole(law: Law, axis: AxisDynamics) -> float:
    """Largest size of a pole of the closed loop in z: below 1 is stable."""
    step_s = law.joint.step_s if isinstance(law, ObservedLaw) else law.step_s
    A, now, before, ticks = _sampled(axis, step_s)
    plant, law_states, read, asked, given = A.shape[0], *_law(law)
    # torques that were sent: the newest is computed from this tick's readings and stands in no state
    sent = ticks + 1
    size = plant + law_states + sent
    x, c, u = slice(0, plant), slice(plant, plant + law_states), slice(plant + law_states, size)
    sensed = np.zeros((2, size))
    sensed[0, 0] = 1.0
    sensed[1, 1 if axis.gyro_rad_s == 0.0 else plant - 2] = 1.0
    torque = np.zeros(size)
    torque[c] = asked[0]
    torque = torque + asked[1] @ sensed
    M = np.zeros((size, size))
    M[x, x] = A
    for k, share in ((ticks, now), (ticks + 1, before)):
        # the torque of k ticks ago
        if k == 0:
            M[x] += np.outer(share, torque)
        else:
            M[x, size - sent + k - 1] += share
    M[c, c] += given[0]
    M[c] += given[1] @ sensed + np.outer(read, torque)
    M[u][0] = torque
    for k in range(1, sent):
        M[u][k, plant + law_states + k - 1] = 1.0
    return float(np.abs(np.linalg.eigvals(M)).max())


def _sampled(axis: AxisDynamics, step_s: float) -> tuple[Matrix, Matrix, Matrix, int]:
    """Axis over a tick: states (joint position, rate, twist and its rate of each mode, gyro and its slope), what the
    torque of `ticks` ago brings and that of one more.
    """
    modes, lagged = len(axis.modes), axis.gyro_rad_s > 0.0
    size = 2 + 2 * modes + (2 if lagged else 0)
    J = axis.inertia_kg_m2 * (1.0 - sum(share for _, _, share in axis.modes))
    F, g = np.zeros((size, size)), np.zeros(size)
    F[0, 1] = 1.0
    F[1, 0], F[1, 1], g[1] = -axis.stiffness_nm / J, -axis.damping_nm_s / J, 1.0 / J
    for k, (w, damping, share) in enumerate(axis.modes):
        twist, hung = 2 + 2 * k, share * axis.inertia_kg_m2
        F[1, twist], F[1, twist + 1] = hung * w * w / J, hung * 2.0 * damping * w / J
    for k, (w, damping, _) in enumerate(axis.modes):
        twist = 2 + 2 * k
        F[twist, twist + 1] = 1.0
        F[twist + 1] = -F[1]
        F[twist + 1, twist] -= w * w
        F[twist + 1, twist + 1] -= 2.0 * damping * w
        g[twist + 1] = -g[1]
    if lagged:
        n = axis.gyro_rad_s
        F[-2, -1] = 1.0
        F[-1, 1], F[-1, -2], F[-1, -1] = n * n, -n * n, -2.0 * axis.gyro_damping * n
    ticks = math.floor(axis.delay_s / step_s + 1e-9)
    rest = max(0.0, axis.delay_s - ticks * step_s)
    whole, held = _held(F, g, step_s)
    _, now = _held(F, g, step_s - rest)
    return whole, now, held - now, ticks


def _held(F: Matrix, g: Matrix, time_s: float) -> tuple[Matrix, Matrix]:
    """Transition over a time, and what an input of one held over its end brings."""
    size = len(g)
    joined = np.zeros((size + 1, size + 1))
    joined[:size, :size], joined[:size, size] = F * time_s, g * time_s
    found = expm(joined)
    return found[:size, :size], found[:size, size]


def _law(law: Law) -> tuple[int, Matrix, tuple[Matrix, Matrix], tuple[Matrix, Matrix]]:
    """States of a law: how many, what its own torque adds to them, torque from (states, readings), and the states of
    the next tick from (states, readings).
    """
    if isinstance(law, CascadeLaw):
        p, i, kp, ki, T = law.position_kp, law.position_ki, law.rate_kp, law.rate_ki, law.step_s
        error = np.array([[-p, -1.0]])
        return (
            2,
            np.zeros(2),
            (np.array([kp, 1.0]), (kp * error)[0]),
            (np.array([[1.0, 0.0], [ki * T, 1.0]]), np.array([[-i * T, 0.0], [-ki * T * p, -ki * T]])),
        )
    if isinstance(law, SampledLaw):
        return len(law.A), np.zeros(len(law.A)), (law.C[0], -law.D[0]), (law.A, -law.B)
    joint, d, J = law.joint, law.delay_ticks, law.inertia_kg_m2
    A, b, K = joint.transition(), torque_input(joint), law.gains
    H = np.zeros((2, 6))
    H[0, 0] = H[1, 4] = 1.0
    kept = np.eye(6) - K @ H
    # states: estimates of the last tick, then the accelerations sent, the newest first
    size = 6 + d + 1
    estimate = np.zeros((6, size))
    estimate[:, :6], estimate[:, 6 + d] = kept @ A, kept @ b
    stiff = law.rate_kp / J
    k = np.array([stiff * law.position_kp, stiff, 1.0])
    ahead = A[:3, :3]
    later = k @ np.linalg.matrix_power(ahead, d)
    asked = -(later @ estimate[:3])
    for n in range(d):
        asked[6 + n] -= k @ np.linalg.matrix_power(ahead, n) @ b[:3]
    own = np.zeros(size)
    own[6] = 1.0 / J
    after = np.zeros((size, size))
    after[:6] = estimate
    for n in range(1, d + 1):
        after[6 + n, 6 + n - 1] = 1.0
    readings = np.zeros((size, 2))
    readings[:6] = K
    return size, own, (J * asked, -J * (later @ K[:3])), (after, readings)
