"""Two-axis gimbal on a moving base: mass matrix and bias torque, and the single axis beside it.

Azimuth turns the outer body about z_b, elevation the inner body about y_o; both inertia tensors are about the common
pivot. `M q'' = T - F + h`, with h everything that does not multiply q''. Newton-Euler form of thesis chapter 2 with the
corrections of ERRATA; checked against MuJoCo and a symbolic Lagrangian in tests/sim_backend.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
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
def symmetric_times(P: np.ndarray, o: int, x: float, y: float, z: float) -> Vector:
    """Inertia tensor at offset o of P times a vector."""
    return (
        P[o + XX] * x + P[o + XY] * y + P[o + XZ] * z,
        P[o + XY] * x + P[o + YY] * y + P[o + YZ] * z,
        P[o + XZ] * x + P[o + YZ] * y + P[o + ZZ] * z,
    )


@compiled
def equations_of_motion(
    P: np.ndarray, K: np.ndarray, q: Pair, v: Pair, base: tuple[Vector, Vector, Vector]
) -> tuple[Vector, Pair, Vector, Vector, Pair]:
    """Mass matrix, bias torque and rates at joint positions q (rad) and rates v (rad/s).

    `base` is gravity (m/s^2), angular rate (rad/s) and angular acceleration (rad/s^2) of the base, in base axes.
    Answers (M11, M12, M22), (h1, h2) in N m, inertial rates of the outer and inner body in their own axes, and the
    inertial accelerations about the two joint axes that remain at q'' = 0.
    """
    turns = ((math.sin(q[0]), math.cos(q[0])), (math.sin(q[1]), math.cos(q[1])))
    return equations_at(P, K, turns, v, base)


@compiled
def equations_at(
    P: np.ndarray, K: np.ndarray, turns: tuple[Pair, Pair], v: Pair, base: tuple[Vector, Vector, Vector]
) -> tuple[Vector, Pair, Vector, Vector, Pair]:
    """`equations_of_motion` for joint positions given as (sine, cosine) of each axis."""
    (se, ce), (si, ci) = turns
    if K[KIND] != _GIMBAL:
        return _single_axis(P, K, se, ce, v[0])
    gravity, rate, acceleration = base
    # outer body: base quantities seen in o, then the joint rate about z
    bx, by = ce * rate[0] + se * rate[1], ce * rate[1] - se * rate[0]
    ox, oy, oz = bx, by, rate[2] + v[0]
    aox = ce * acceleration[0] + se * acceleration[1] + v[0] * by
    aoy = ce * acceleration[1] - se * acceleration[0] - v[0] * bx
    aoz = acceleration[2]
    gox, goy, goz = ce * gravity[0] + se * gravity[1], ce * gravity[1] - se * gravity[0], gravity[2]
    # inner body: outer quantities seen in i, then the joint rate about y
    px, pz = ci * ox - si * oz, si * ox + ci * oz
    ix, iy, iz = px, oy + v[1], pz
    aix = ci * aox - si * aoz - v[1] * pz
    aiy = aoy
    aiz = si * aox + ci * aoz + v[1] * px
    gix, giy, giz = ci * gox - si * goz, goy, si * gox + ci * goz
    # rate of change of the inner body's angular momentum at q'' = 0, in i
    hx, hy, hz = symmetric_times(P, INERTIA_INNER, ix, iy, iz)
    nx, ny, nz = symmetric_times(P, INERTIA_INNER, aix, aiy, aiz)
    dix, diy, diz = nx + iy * hz - iz * hy, ny + iz * hx - ix * hz, nz + ix * hy - iy * hx
    mi = P[MASS_INNER]
    wix = mi * (P[COG_INNER + 1] * giz - P[COG_INNER + 2] * giy)
    wiy = mi * (P[COG_INNER + 2] * gix - P[COG_INNER] * giz)
    wiz = mi * (P[COG_INNER] * giy - P[COG_INNER + 1] * gix)
    # the outer body's own, in o; nothing where the base does not turn
    doz = 0.0
    if ox != 0.0 or oy != 0.0 or aox != 0.0 or aoy != 0.0 or aoz != 0.0:
        hx, hy, _ = symmetric_times(P, INERTIA_OUTER, ox, oy, oz)
        _, _, nz = symmetric_times(P, INERTIA_OUTER, aox, aoy, aoz)
        doz = nz + ox * hy - oy * hx
    lever_z = P[COG_OUTER] * goy - P[COG_OUTER + 1] * gox
    if K[GRAVITY_READING] == _TOTAL_MASS:
        woz = (P[MASS_OUTER] + mi) * lever_z
    else:
        woz = P[MASS_OUTER] * lever_z - si * wix + ci * wiz
    m11 = P[INERTIA_OUTER + ZZ] + si * si * P[INERTIA_INNER + XX] - 2.0 * si * ci * P[INERTIA_INNER + XZ] + ci * ci * P[INERTIA_INNER + ZZ]
    m12 = ci * P[INERTIA_INNER + YZ] - si * P[INERTIA_INNER + XY]
    h1 = woz - doz - (ci * diz - si * dix)
    h2 = wiy - diy
    return (m11, m12, P[INERTIA_INNER + YY]), (h1, h2), (ox, oy, oz), (ix, iy, iz), (aoz, aiy)


@compiled
def _single_axis(P: np.ndarray, K: np.ndarray, sine: float, cosine: float, v: float) -> tuple[Vector, Pair, Vector, Vector, Pair]:
    g = P[GRAVITY_M_S2]
    if K[KIND] == _LINEAR:
        bias = -P[MASS_OUTER] * g * P[INCLINE_SIN]
        return (P[MASS_OUTER], 0.0, 1.0), (bias, 0.0), (0.0, 0.0, v), (0.0, 0.0, 0.0), (0.0, 0.0)
    # a horizontal axis: centre of mass at (cog_x, cog_y) in the body, x level at q = 0; INCLINE_SIN is 1 there and 0 for a vertical axis
    bias = -P[MASS_OUTER] * g * P[INCLINE_SIN] * (P[COG_OUTER] * cosine - P[COG_OUTER + 1] * sine)
    return (P[INERTIA_OUTER + ZZ], 0.0, 1.0), (bias, 0.0), (0.0, 0.0, v), (0.0, 0.0, 0.0), (0.0, 0.0)


@compiled
def expand_turns(X: np.ndarray) -> None:
    """Once a tick: the joint positions about which `turns_near` expands, with their sine and cosine."""
    for axis in range(2):
        e = EXPANSION + axis * EXPANSION_SIZE
        X[e], X[e + 1], X[e + 2] = X[POSITION + axis], math.sin(X[POSITION + axis]), math.cos(X[POSITION + axis])


@compiled
def turns_near(X: np.ndarray, axis: int, q: float) -> Pair:
    """(sine, cosine) of a position near that of the tick's start, to double precision at a tenth of the cost."""
    e = EXPANSION + axis * EXPANSION_SIZE
    d = q - X[e]
    if abs(d) > 0.02:
        return math.sin(q), math.cos(q)
    d2 = d * d
    sine = d * (1.0 - d2 * (1 / 6 - d2 * (1 / 120 - d2 * (1 / 5040))))
    cosine = 1.0 - d2 * (1 / 2 - d2 * (1 / 24 - d2 * (1 / 720)))
    return X[e + 1] * cosine + X[e + 2] * sine, X[e + 2] * cosine - X[e + 1] * sine
