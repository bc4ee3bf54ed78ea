"""How the base moves: gravity less the acceleration of the pivot, angular rate and angular acceleration in base axes as
functions of time.

Attitude is `R_eb = Rz(yaw) Ry(pitch) Rx(roll)`, z up. Constant body rates are solved in closed form, sinusoids are sums
in the Euler angles, a recorded motion is interpolated linearly between its rows.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import sine_cosine
from sim_backend.layout import (
    BASE_AMPLITUDE,
    BASE_ATTITUDE,
    BASE_COLUMNS,
    BASE_FREQUENCY,
    BASE_KIND,
    BASE_PHASE,
    BASE_RATE,
    BASE_ROW_S,
    BASE_ROWS,
    BASE_TABLE,
    FIXED_GRAVITY,
    GRAVITY_M_S2,
    BaseKind,
)

_FIXED, _CONSTANT, _SINUSOID = int(BaseKind.FIXED), int(BaseKind.CONSTANT_RATE), int(BaseKind.SINUSOID)
_RECORDED = int(BaseKind.RECORDED)
Vector = tuple[float, float, float]


@compiled
def base_state(P: np.ndarray, K: np.ndarray, t: float) -> tuple[Vector, Vector, Vector]:
    """Gravity less the acceleration of the pivot (m/s^2), angular rate (rad/s) and angular acceleration (rad/s^2) of
    the base at t seconds, in base axes.
    """
    kind = K[BASE_KIND]
    if kind == _FIXED:
        return base_at_rest(P)
    if kind == _CONSTANT:
        return _constant_rate(P, t)
    if kind == _SINUSOID:
        return _sinusoid(P, t)
    return _recorded(P, K, t)


@compiled
def base_at_rest(P: np.ndarray) -> tuple[Vector, Vector, Vector]:
    """`base_state` of a base that does not move."""
    return (P[FIXED_GRAVITY], P[FIXED_GRAVITY + 1], P[FIXED_GRAVITY + 2]), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)


@compiled
def base_attitude(P: np.ndarray, K: np.ndarray, t: float) -> Vector:
    """Roll, pitch and yaw of the base (rad) at t seconds."""
    kind = K[BASE_KIND]
    if kind == _FIXED:
        return P[BASE_ATTITUDE], P[BASE_ATTITUDE + 1], P[BASE_ATTITUDE + 2]
    if kind == _CONSTANT:
        return _euler_angles(P, t)
    if kind == _SINUSOID:
        return _angle(P, 0, t)[0], _angle(P, 1, t)[0], _angle(P, 2, t)[0]
    row, share = _row(P, K, t)
    return _between(P, row, share, 0), _between(P, row, share, 1), _between(P, row, share, 2)


@compiled
def pivot_acceleration(P: np.ndarray, K: np.ndarray, t: float) -> Vector:
    """Acceleration of the pivot (m/s^2, base axes, gravity not included) at t seconds."""
    if K[BASE_KIND] != _RECORDED:
        return 0.0, 0.0, 0.0
    row, share = _row(P, K, t)
    return _between(P, row, share, 9), _between(P, row, share, 10), _between(P, row, share, 11)


@compiled
def gravity_in_base(g: float, roll: float, pitch: float) -> Vector:
    """R_eb^T (0, 0, -g)."""
    return gravity_at(g, sine_cosine(roll), sine_cosine(pitch))


@compiled
def gravity_at(g: float, roll: tuple[float, float], pitch: tuple[float, float]) -> Vector:
    """`gravity_in_base` for angles given as (sine, cosine)."""
    return g * pitch[0], -g * pitch[1] * roll[0], -g * pitch[1] * roll[1]


@compiled
def body_rates(roll: float, pitch: float, droll: float, dpitch: float, dyaw: float) -> Vector:
    """Body rates p, q, r from Euler angle rates (3-2-1)."""
    (sr, cr), (sp, cp) = sine_cosine(roll), sine_cosine(pitch)
    return droll - dyaw * sp, dpitch * cr + dyaw * sr * cp, -dpitch * sr + dyaw * cr * cp


@compiled
def _constant_rate(P: np.ndarray, t: float) -> tuple[Vector, Vector, Vector]:
    p, q, r = P[BASE_RATE], P[BASE_RATE + 1], P[BASE_RATE + 2]
    # FIXED_GRAVITY is that of t = 0
    return _turned(P[FIXED_GRAVITY], P[FIXED_GRAVITY + 1], P[FIXED_GRAVITY + 2], p, q, r, t), (p, q, r), (0.0, 0.0, 0.0)


@compiled
def _turned(x: float, y: float, z: float, p: float, q: float, r: float, t: float) -> Vector:
    """A vector fixed in space seen after t seconds from axes that turn at constant body rates: exp(-[w] t) x
    (Rodrigues).
    """
    rate = math.sqrt(p * p + q * q + r * r)
    if rate == 0.0:
        return x, y, z
    ux, uy, uz = p / rate, q / rate, r / rate
    s, c = sine_cosine(-rate * t)
    d = (ux * x + uy * y + uz * z) * (1.0 - c)
    return (
        c * x + s * (uy * z - uz * y) + d * ux,
        c * y + s * (uz * x - ux * z) + d * uy,
        c * z + s * (ux * y - uy * x) + d * uz,
    )


@compiled
def _euler_angles(P: np.ndarray, t: float) -> Vector:
    roll, pitch, yaw = P[BASE_ATTITUDE], P[BASE_ATTITUDE + 1], P[BASE_ATTITUDE + 2]
    p, q, r = P[BASE_RATE], P[BASE_RATE + 1], P[BASE_RATE + 2]
    (sr, cr), (sp, cp), (sy, cy) = sine_cosine(roll), sine_cosine(pitch), sine_cosine(yaw)
    # rows of R_eb at t = 0 are the earth axes seen from the base; turn each
    xx, _, _ = _turned(cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr, p, q, r, t)
    yx, _, _ = _turned(sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr, p, q, r, t)
    zx, zy, zz = _turned(-sp, cp * sr, cp * cr, p, q, r, t)
    return math.atan2(zy, zz), math.asin(min(1.0, max(-1.0, -zx))), math.atan2(yx, xx)


@compiled
def _angle(P: np.ndarray, i: int, t: float) -> Vector:
    amplitude, w = P[BASE_AMPLITUDE + i], 2.0 * math.pi * P[BASE_FREQUENCY + i]
    phase = w * t + P[BASE_PHASE + i]
    s, c = sine_cosine(phase)
    return P[BASE_ATTITUDE + i] + amplitude * s, amplitude * w * c, -amplitude * w * w * s


@compiled
def _sinusoid(P: np.ndarray, t: float) -> tuple[Vector, Vector, Vector]:
    roll, droll, ddroll = _angle(P, 0, t)
    pitch, dpitch, ddpitch = _angle(P, 1, t)
    _, dyaw, ddyaw = _angle(P, 2, t)
    (sr, cr), (sp, cp) = sine_cosine(roll), sine_cosine(pitch)
    rates = (droll - dyaw * sp, dpitch * cr + dyaw * sr * cp, -dpitch * sr + dyaw * cr * cp)
    accelerations = (
        ddroll - ddyaw * sp - dyaw * cp * dpitch,
        ddpitch * cr - dpitch * sr * droll + ddyaw * sr * cp + dyaw * (cr * cp * droll - sr * sp * dpitch),
        -ddpitch * sr - dpitch * cr * droll + ddyaw * cr * cp - dyaw * (sr * cp * droll + cr * sp * dpitch),
    )
    return gravity_in_base(P[GRAVITY_M_S2], roll, pitch), rates, accelerations


@compiled
def _row(P: np.ndarray, K: np.ndarray, t: float) -> tuple[int, float]:
    """Offset of the row before t and the share of the next one; the last row holds at rest after the end."""
    position = t / P[BASE_ROW_S]
    last = K[BASE_ROWS] - 2
    row = min(max(int(position), 0), last)
    return K[BASE_TABLE] + row * BASE_COLUMNS, min(max(position - row, 0.0), 1.0)


@compiled
def _between(P: np.ndarray, row: int, share: float, column: int) -> float:
    before = P[row + column]
    return before + share * (P[row + BASE_COLUMNS + column] - before)


@compiled
def _recorded(P: np.ndarray, K: np.ndarray, t: float) -> tuple[Vector, Vector, Vector]:
    row, share = _row(P, K, t)
    gx, gy, gz = gravity_in_base(P[GRAVITY_M_S2], _between(P, row, share, 0), _between(P, row, share, 1))
    # bodies that are carried along by an accelerated pivot feel it as gravity the other way
    felt = (gx - _between(P, row, share, 9), gy - _between(P, row, share, 10), gz - _between(P, row, share, 11))
    rate = (_between(P, row, share, 3), _between(P, row, share, 4), _between(P, row, share, 5))
    return felt, rate, (_between(P, row, share, 6), _between(P, row, share, 7), _between(P, row, share, 8))
