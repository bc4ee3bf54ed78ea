"""The thesis' slips as switches: what the printed equations add to the corrected bias torque.

Only for showing what each slip does (`gimbal-hil experiment thesis`); every model of an antenna has them off. Each is
the printed form minus the corrected one, with everything else left right, so that they add up.
"""

from __future__ import annotations

from enum import IntFlag

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import sine_cosine
from sim_backend.friction import stribeck_level
from sim_backend.layout import (
    AXIS_BLOCK,
    AXIS_SIZE,
    COG_INNER,
    COG_OUTER,
    DELTA,
    GRAVITY_READING,
    INERTIA_INNER,
    INERTIA_OUTER,
    INNER,
    MASS_INNER,
    MASS_OUTER,
    OUTER,
    SIGMA2,
    SLIPS,
    TC,
    TS,
    VS,
    GravityReading,
)

Vector = tuple[float, float, float]


class Slip(IntFlag):
    """The printed forms in docs/explanation/reading-the-thesis.md that can be switched on."""

    NONE = 0
    #: eq. 2.58, 3.3, 3.4: derivative of R_oi without its factor, the elevation rate
    MISSING_ELEVATION_RATE = 1
    #: eq. 2.13, 2.22, 2.23: derivative of R_ob and R_io with the wrong sign (the base's own rates enter as given)
    DERIVATIVE_SIGN = 2
    #: eq. 3.10: the y row of r x g for the torque about z, with the total mass
    GRAVITY_ROW = 4
    #: eq. 2.54, 2.58: the inner joint's friction acts on the outer axis as well
    INNER_FRICTION_ON_OUTER = 8
    #: eq. 2.42, 2.55: friction is added to the motor's torque
    FRICTION_ADDED = 16


_RATE, _SIGN, _ROW = int(Slip.MISSING_ELEVATION_RATE), int(Slip.DERIVATIVE_SIGN), int(Slip.GRAVITY_ROW)
_ON_OUTER, _ADDED = int(Slip.INNER_FRICTION_ON_OUTER), int(Slip.FRICTION_ADDED)
_TOTAL_MASS = int(GravityReading.TOTAL_MASS)


@compiled
def slip_torque(
    P: np.ndarray, K: np.ndarray, q: tuple[float, float], v: tuple[float, float], base: tuple[Vector, Vector, Vector]
) -> tuple[float, float]:
    """Bias torque that the slips in K[SLIPS] add on the two axes, N m."""
    slips = K[SLIPS]
    (se, ce), (si, ci) = sine_cosine(q[0]), sine_cosine(q[1])
    gravity, rate, _ = base
    # rates of the outer body in o (joint rate added), of the inner body in i
    bx, by = ce * rate[0] + se * rate[1], ce * rate[1] - se * rate[0]
    oz = rate[2] + v[0]
    px, pz = ci * bx - si * oz, si * bx + ci * oz
    outer, inner = 0.0, 0.0
    if slips & _RATE:
        hx = _row(P, INERTIA_INNER, 0, px, by + v[1], pz)
        hz = _row(P, INERTIA_INNER, 2, px, by + v[1], pz)
        # z row of dR_oi/deps H: printed once, right times the elevation rate
        outer -= (1.0 - v[1]) * (-ci * hx - si * hz)
    if slips & _SIGN:
        # twice the right derivative terms of alpha_oe and alpha_ie, taken off
        dx, dy = -2.0 * v[0] * by, 2.0 * v[0] * bx
        ex, ey, ez = ci * dx + 2.0 * v[1] * pz, dy, si * dx - 2.0 * v[1] * px
        outer -= _row(P, INERTIA_OUTER, 2, dx, dy, 0.0)
        outer -= -si * _row(P, INERTIA_INNER, 0, ex, ey, ez) + ci * _row(P, INERTIA_INNER, 2, ex, ey, ez)
        inner -= _row(P, INERTIA_INNER, 1, ex, ey, ez)
    if slips & _ROW:
        outer += _printed_gravity(P, K, (se, ce), (si, ci), gravity)
    if slips & _ON_OUTER:
        outer -= _steady_friction(P, INNER, v[1])
    if slips & _ADDED:
        outer += 2.0 * _steady_friction(P, OUTER, v[0])
        inner += 2.0 * _steady_friction(P, INNER, v[1])
    return outer, inner


@compiled
def _row(P: np.ndarray, o: int, row: int, x: float, y: float, z: float) -> float:
    """One row of the inertia tensor at offset o (xx, yy, zz, xy, xz, yz) times a vector."""
    if row == 0:
        return P[o] * x + P[o + 3] * y + P[o + 4] * z
    if row == 1:
        return P[o + 3] * x + P[o + 1] * y + P[o + 5] * z
    return P[o + 4] * x + P[o + 5] * y + P[o + 2] * z


@compiled
def _printed_gravity(
    P: np.ndarray, K: np.ndarray, outer: tuple[float, float], inner: tuple[float, float], gravity: Vector
) -> float:
    """Gravity torque about z of eq. 3.10 less the one of the model's own reading, N m."""
    (se, ce), (si, ci) = outer, inner
    gx, gy, gz = ce * gravity[0] + se * gravity[1], ce * gravity[1] - se * gravity[0], gravity[2]
    total = P[MASS_OUTER] + P[MASS_INNER]
    printed = total * (P[COG_OUTER + 2] * gx - gz * P[COG_OUTER])
    right = P[COG_OUTER] * gy - P[COG_OUTER + 1] * gx
    if K[GRAVITY_READING] == _TOTAL_MASS:
        return printed - total * right
    gix, giz = ci * gx - si * gz, si * gx + ci * gz
    wx = P[COG_INNER + 1] * giz - P[COG_INNER + 2] * gy
    wz = P[COG_INNER] * gy - P[COG_INNER + 1] * gix
    return printed - P[MASS_OUTER] * right - P[MASS_INNER] * (ci * wz - si * wx)


@compiled
def _steady_friction(P: np.ndarray, axis: int, v: float) -> float:
    """Friction of a joint that has been turning at v (rad/s) for long, N m."""
    block = AXIS_BLOCK + axis * AXIS_SIZE
    level = stribeck_level(abs(v), P[block + TS], P[block + TC], P[block + VS], P[block + DELTA])
    return (level if v > 0.0 else (-level if v < 0.0 else 0.0)) + P[block + SIGMA2] * v
