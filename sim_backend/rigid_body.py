"""Two-axis gimbal on a moving base: mass matrix and bias torque, and the single axis beside it.

Azimuth turns the outer body about z_b, elevation the inner body about y_o; both inertia tensors are about the common
pivot. `M q'' = T - F + h`, with h everything that does not multiply q''. Newton-Euler form of thesis chapter 2 with the
corrections in docs/explanation/reading-the-thesis.md; checked against MuJoCo and a symbolic Lagrangian in
tests/sim_backend.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import sine_cosine
from sim_backend.layout import (
    COG_INNER,
    COG_OUTER,
    EXPANSION,
    EXPANSION_SIZE,
    GRAVITY_M_S2,
    GRAVITY_READING,
    INCLINE_SIN,
    INERTIA_INNER,
    INERTIA_OUTER,
    KIND,
    MASS_INNER,
    MASS_OUTER,
    POSITION,
    XX,
    XY,
    XZ,
    YY,
    YZ,
    ZZ,
    GravityReading,
    PlantKind,
)

_GIMBAL, _LINEAR = int(PlantKind.GIMBAL), int(PlantKind.LINEAR)
_TOTAL_MASS = int(GravityReading.TOTAL_MASS)
Vector = tuple[float, float, float]
Pair = tuple[float, float]


@compiled
def equations_of_motion(
    P: np.ndarray, K: np.ndarray, q: Pair, v: Pair, base: tuple[Vector, Vector, Vector]
) -> tuple[Vector, Pair, Vector, Vector, Pair]:
    """Mass matrix, bias torque and rates at joint positions q (rad) and rates v (rad/s).

    `base` is gravity (m/s^2), angular rate (rad/s) and angular acceleration (rad/s^2) of the base, in base axes.
    Answers (M11, M12, M22), (h1, h2) in N m, inertial rates of the outer and inner body in their own axes, and the
    inertial accelerations about the two joint axes that remain at q'' = 0.
    """
    turning = base[1] != (0.0, 0.0, 0.0) or base[2] != (0.0, 0.0, 0.0)
    turns = (sine_cosine(q[0]), sine_cosine(q[1]))
    return equations_at(P, K, body_numbers(P, K, (0.0, 1.0)), turns, v, base, K[KIND] == _GIMBAL, turning)


@compiled
def body_numbers(P: np.ndarray, K: np.ndarray, turn: Pair) -> tuple[Vector, Vector, Vector, Vector]:
    """What the equations of the gimbal want of P, once for many steps, the inner body seen in axes turned by `turn`
    (sine, cosine).

    With q the inner position from there: M11 = a + b cos 2q + c sin 2q; products of inertia yz, xy and M22; first
    moments of the inner body (kg m); of the outer one x, y as gravity about z sees them, y with the inner body's, and
    the share of the inner x that joins.
    """
    i, mi = INERTIA_INNER, P[MASS_INNER]
    s, c = turn
    s2, c2 = 2.0 * s * c, 1.0 - 2.0 * s * s
    half, cross = 0.5 * (P[i + ZZ] - P[i + XX]), -P[i + XZ]
    mass, share = P[MASS_OUTER], 1.0
    if K[GRAVITY_READING] == _TOTAL_MASS:
        mass, share = mass + mi, 0.0
    turned = (P[INERTIA_OUTER + ZZ] + 0.5 * (P[i + XX] + P[i + ZZ]), half * c2 + cross * s2, cross * c2 - half * s2)
    products = (c * P[i + YZ] - s * P[i + XY], c * P[i + XY] + s * P[i + YZ], P[i + YY])
    mx, my, mz = mi * P[COG_INNER], mi * P[COG_INNER + 1], mi * P[COG_INNER + 2]
    outer = (mass * P[COG_OUTER], mass * P[COG_OUTER + 1] + share * my, share)
    return turned, products, (c * mx + s * mz, my, c * mz - s * mx), outer


@compiled
def equations_at(
    P: np.ndarray,
    K: np.ndarray,
    body: tuple[Vector, Vector, Vector, Vector],
    turns: tuple[Pair, Pair],
    v: Pair,
    base: tuple[Vector, Vector, Vector],
    gimbal: bool,
    turning: bool,
) -> tuple[Vector, Pair, Vector, Vector, Pair]:
    """`equations_of_motion` with (sine, cosine) of each joint position, the inner one from where `body` is seen, as its
    rates are.

    `gimbal` False is the single axis, `turning` False a base that does not turn. The outer position counts where
    `outer_turn_counts`.
    """
    (se, ce), (si, ci) = turns
    if not gimbal:
        return _single_axis(P, K, se, ce, v[0])
    gravity, rate, acceleration = base
    (a, b, c), (yz, xy, m22), (mx, _, mz), (ox, oy, share) = body
    # kinetic energy (M11 oz^2 + 2 M12 oz v + M22 v^2) / 2 of two bodies that share the rate oz about z
    sine2, cosine2 = (si + si) * ci, 1.0 - (si + si) * si
    oz = rate[2] + v[0]
    half_slope = c * cosine2 - b * sine2
    mass = (a + (b * cosine2 + c * sine2), ci * yz - si * xy, m22)
    h1 = ((ci * xy + si * yz) * v[1] - (half_slope + half_slope) * oz) * v[1]
    # first moment of the inner body in outer axes; its y part stays
    h2 = half_slope * (oz * oz) - (ci * mx + si * mz) * gravity[2]
    if gravity[0] != 0.0 or gravity[1] != 0.0:
        gx, gy = ce * gravity[0] + se * gravity[1], ce * gravity[1] - se * gravity[0]
        h1 += (ox + share * (ci * mx + si * mz)) * gy - oy * gx
        h2 += (ci * mz - si * mx) * gx
    if not turning:
        return mass, (h1, h2), (0.0, 0.0, oz), (-si * oz, v[1], ci * oz), (0.0, 0.0)
    wx, wy = ce * rate[0] + se * rate[1], ce * rate[1] - se * rate[0]
    ao = (
        ce * acceleration[0] + se * acceleration[1] + v[0] * wy,
        ce * acceleration[1] - se * acceleration[0] - v[0] * wx,
        acceleration[2],
    )
    extra = _turning_torque(P, body, (si, ci), (wx, wy, oz), v[1], ao)
    inner = (ci * wx - si * oz, wy + v[1], si * wx + ci * oz)
    return mass, (h1 - extra[0], h2 - extra[1]), (wx, wy, oz), inner, (ao[2], ao[1])


@compiled
def outer_turn_counts(gravity: Vector, gimbal: bool, turning: bool) -> bool:
    """Whether the outer position enters the equations: not on a level base that does not turn."""
    return bool(turning or gravity[0] != 0.0 or gravity[1] != 0.0 or not gimbal)


@compiled
def _turning_torque(
    P: np.ndarray, body: tuple[Vector, Vector, Vector, Vector], turn: Pair, outer: Vector, v: float, ao: Vector
) -> Pair:
    """What a turning base takes from both joints beside oz: rates of change of angular momentum with the outer body's
    rates ox, oy in them, and all that its acceleration `ao` brings. The inner body's rate is w + u, with u what it has
    at ox = oy = 0.
    """
    si, ci = turn
    ox, oy, oz = outer
    wx, wy, wz = ci * ox, oy, si * ox
    ux, uy, uz = -si * oz, v, ci * oz
    (a, b, c), (yz, xy, yy), _, _ = body
    mean = a - P[INERTIA_OUTER + ZZ]
    inner = (mean - b, yy, mean + b, xy, -c, yz)
    hx, hy, hz = _tensor_times(inner, wx, wy, wz)
    kx, ky, kz = _tensor_times(inner, wx + ux, wy + uy, wz + uz)
    nx, ny, nz = _tensor_times(inner, ci * ao[0] - si * ao[2] - v * wz, ao[1], si * ao[0] + ci * ao[2] + v * wx)
    dx = nx + (wy * kz - wz * ky) + (uy * hz - uz * hy)
    dy = ny + (wz * kx - wx * kz) + (uz * hx - ux * hz)
    dz = nz + (wx * ky - wy * kx) + (ux * hy - uy * hx)
    o = INERTIA_OUTER
    gx = P[o + XX] * ox + P[o + XY] * oy + P[o + XZ] * oz
    gy = P[o + XY] * ox + P[o + YY] * oy + P[o + YZ] * oz
    gz = P[o + XZ] * ao[0] + P[o + YZ] * ao[1] + P[o + ZZ] * ao[2]
    return gz + ox * gy - oy * gx + ci * dz - si * dx, dy


@compiled
def _tensor_times(tensor: tuple[float, float, float, float, float, float], x: float, y: float, z: float) -> Vector:
    """Inertia tensor (xx, yy, zz, xy, xz, yz) times a vector."""
    xx, yy, zz, xy, xz, yz = tensor
    return xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z


@compiled
def _single_axis(
    P: np.ndarray, K: np.ndarray, sine: float, cosine: float, v: float
) -> tuple[Vector, Pair, Vector, Vector, Pair]:
    g = P[GRAVITY_M_S2]
    if K[KIND] == _LINEAR:
        bias = -P[MASS_OUTER] * g * P[INCLINE_SIN]
        return (P[MASS_OUTER], 0.0, 1.0), (bias, 0.0), (0.0, 0.0, v), (0.0, 0.0, 0.0), (0.0, 0.0)
    # a horizontal axis: centre of mass at (cog_x, cog_y) in the body, x level at q = 0; INCLINE_SIN is 1 there and 0
    # for a vertical axis
    bias = -P[MASS_OUTER] * g * P[INCLINE_SIN] * (P[COG_OUTER] * cosine - P[COG_OUTER + 1] * sine)
    return (P[INERTIA_OUTER + ZZ], 0.0, 1.0), (bias, 0.0), (0.0, 0.0, v), (0.0, 0.0, 0.0), (0.0, 0.0)


@compiled
def expand_turns(X: np.ndarray, outer_counts: bool) -> None:
    """Once a tick: the joint positions that steps count from, with their sine and cosine, where they are not there
    already; without those of the outer one where it does not count.
    """
    for axis in range(2):
        e = EXPANSION + axis * EXPANSION_SIZE
        if X[e] != X[POSITION + axis]:
            X[e] = X[POSITION + axis]
            if outer_counts or axis == 1:
                X[e + 1], X[e + 2] = sine_cosine(X[e])


@compiled
def turn_centre(X: np.ndarray, axis: int) -> Vector:
    """Position (rad) about which an axis is expanded, with its sine and cosine."""
    e = EXPANSION + axis * EXPANSION_SIZE
    return X[e], X[e + 1], X[e + 2]


@compiled
def turn_by(d: float) -> Pair:
    """(sine, cosine) of the small angles that a joint turns within a tick, to double precision at a third of the
    cost.
    """
    if not abs(d) <= 0.02:
        return sine_cosine(d)
    d2 = d * d
    d4 = d2 * d2
    return d - (d * d2) * (((1 / 6) - d2 * (1 / 120)) + d4 * (1 / 5040)), 1.0 - d2 * (
        ((1 / 2) - d2 * (1 / 24)) + d4 * (1 / 720)
    )


@compiled
def turned_from(centre: Vector, d: float) -> Pair:
    """(sine, cosine) at an angle d from `centre` (position, sine, cosine)."""
    s, c = turn_by(d)
    return centre[1] * c + centre[2] * s, centre[2] * c - centre[1] * s
