"""Joint references that hold a direction in space while the base moves, by exact kinematics from attitude and rates.

A direction is given as the joint positions that look there from a level base of heading zero: azimuth about z (up),
elevation about y, positive downwards by the right hand. With d the direction in base axes and w the base's rate,
d' = -w x d (+ the direction's own motion), and azimuth = atan2(dy, dx), elevation = -asin(dz).
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import sine_cosine
from gimbal_hil.loop.host.base_now import mean_rates
from gimbal_hil.loop.host.layout import (
    ATTITUDE_AGE_S,
    BASE_ANGLES,
    BASE_NOW,
    BASE_RATES,
    BASE_TURNING,
    CARRIED,
    CARRIED_ANGLES,
    CARRIED_RATES,
    EXTRAPOLATES_BASE,
)

Vector = tuple[float, float, float]
_TWO_PI = 2.0 * math.pi
#: nearer to the zenith than this cosine of the elevation, azimuth has no slope that a joint could follow (0.6 deg)
_KEYHOLE = 0.01
#: age up to which an attitude is turned on (s)
_MOST_AGE_S = 0.1


@compiled
def direction_now(
    azimuth: float, elevation: float, azimuth_rate: float, elevation_rate: float, H: np.ndarray, C: np.ndarray
) -> tuple[Vector, Vector, Vector]:
    """A direction in space (rad, rad/s) in base axes, and its first two derivatives there: from the base as last told,
    or as it is now.
    """
    (sa, ca), (se, ce) = sine_cosine(azimuth), sine_cosine(elevation)
    towards = (ce * ca, ce * sa, -se)
    own = (
        -azimuth_rate * ce * sa - elevation_rate * se * ca,
        azimuth_rate * ce * ca - elevation_rate * se * sa,
        -elevation_rate * ce,
    )
    if H[CARRIED] > 0.0:
        angles, rates = CARRIED_ANGLES, CARRIED_RATES
    else:
        angles, rates = BASE_ANGLES, BASE_RATES
    d, moved = _in_base(towards, H, angles), _in_base(own, H, angles)
    w, turning = (H[rates], H[rates + 1], H[rates + 2]), (0.0, 0.0, 0.0)
    if C[EXTRAPOLATES_BASE] > 0.0 and H[CARRIED] == 0.0:
        age = min(H[ATTITUDE_AGE_S], _MOST_AGE_S)
        w = (H[BASE_NOW], H[BASE_NOW + 1], H[BASE_NOW + 2])
        turning = (H[BASE_TURNING], H[BASE_TURNING + 1], H[BASE_TURNING + 2])
        mean = mean_rates(H, age)
        d, moved = _turned_on(d, mean, age), _turned_on(moved, mean, age)
    carried = _cross(w, d)
    rate = (moved[0] - carried[0], moved[1] - carried[1], moved[2] - carried[2])
    # d'' = -w' x d - w x d' - w x (own motion), the last as the rotating axes see it
    a, b, c = _cross(turning, d), _cross(w, rate), _cross(w, moved)
    return d, rate, (-a[0] - b[0] - c[0], -a[1] - b[1] - c[1], -a[2] - b[2] - c[2])


@compiled
def nearest_turn(azimuth: float, before: float, low: float, high: float) -> float:
    """The turn of an azimuth (rad) nearest to where the joint was told to be before, or the next one that the cable
    allows.
    """
    near = azimuth + _TWO_PI * math.floor((before - azimuth) / _TWO_PI + 0.5)
    if near > high and near - _TWO_PI >= low:
        return near - _TWO_PI
    if near < low and near + _TWO_PI <= high:
        return near + _TWO_PI
    return near


@compiled
def joints_of(d: Vector, rate: Vector, curve: Vector) -> tuple[Vector, Vector]:
    """Both joints (rad, rad/s, rad/s^2) from a direction in base axes and its two derivatives."""
    level = math.sqrt(d[0] * d[0] + d[1] * d[1])
    azimuth, elevation = math.atan2(d[1], d[0]), math.atan2(-d[2], level)
    if level < _KEYHOLE:
        return (azimuth, 0.0, 0.0), (elevation, 0.0, 0.0)
    square = level * level
    out = (d[0] * rate[0] + d[1] * rate[1]) / square
    azimuth_rate = (d[0] * rate[1] - d[1] * rate[0]) / square
    azimuth_curve = (d[0] * curve[1] - d[1] * curve[0]) / square - 2.0 * azimuth_rate * out
    elevation_rate = -rate[2] / level
    elevation_curve = -curve[2] / level - d[2] * elevation_rate * elevation_rate / level
    return (azimuth, azimuth_rate, azimuth_curve), (elevation, elevation_rate, elevation_curve)


@compiled
def looks_along(outer: float, inner: float) -> Vector:
    """Direction in base axes in which the antenna looks at joint positions (rad)."""
    (sa, ca), (se, ce) = sine_cosine(outer), sine_cosine(inner)
    return ce * ca, ce * sa, -se


@compiled
def angle_between(a: Vector, b: Vector) -> float:
    """Angle (rad) between two unit vectors, exact for small ones too."""
    c = _cross(a, b)
    return math.atan2(math.sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]), a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@compiled
def _in_base(x: Vector, H: np.ndarray, angles: int) -> Vector:
    """An earth vector in the axes of the base with the attitude at `angles`: Rx(roll)^T Ry(pitch)^T Rz(yaw)^T."""
    (sr, cr), (sp, cp), (sy, cy) = (
        sine_cosine(H[angles]),
        sine_cosine(H[angles + 1]),
        sine_cosine(H[angles + 2]),
    )
    x1, y1 = cy * x[0] + sy * x[1], cy * x[1] - sy * x[0]
    x2, z2 = cp * x1 - sp * x[2], sp * x1 + cp * x[2]
    return x2, cr * y1 + sr * z2, cr * z2 - sr * y1


@compiled
def _turned_on(x: Vector, w: Vector, age_s: float) -> Vector:
    """A vector fixed in space, seen `age_s` later from axes that turn at w (rad/s): exp(-[w] t) x to third order."""
    a = _cross(w, x)
    b = _cross(w, a)
    c = _cross(w, b)
    t2, t3 = 0.5 * age_s * age_s, age_s * age_s * age_s / 6.0
    return (
        x[0] - age_s * a[0] + t2 * b[0] - t3 * c[0],
        x[1] - age_s * a[1] + t2 * b[1] - t3 * c[1],
        x[2] - age_s * a[2] + t2 * b[2] - t3 * c[2],
    )


@compiled
def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
