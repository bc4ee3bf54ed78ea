"""What the loops need not find out for themselves: base rate about each axis, gravity on unbalanced bodies, friction.

Conventions as in the thesis with its corrections: azimuth turns the outer body about z_b, elevation the inner
one about y_o; R_eb = Rz(yaw) Ry(pitch) Rx(roll), z up.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import sine_cosine
from gimbal_hil.loop.control.layout import COULOMB, SIGN_WIDTH, VISCOUS

GRAVITY_M_S2 = 9.81


@compiled
def base_rates(azimuth: float, p: float, q: float, r: float) -> tuple[float, float]:
    """Inertial rates (rad/s) of the two axes when the joints rest: r about z_o, and the base rate's part along y_o."""
    if p == 0.0 and q == 0.0:
        return r, 0.0
    sine, cosine = sine_cosine(azimuth)
    return r, cosine * q - sine * p


@compiled
def friction_torque(joint_rate: float, C: np.ndarray, c: int) -> float:
    """Torque (N m) that overcomes Coulomb and viscous friction at a wanted joint rate (rad/s), smooth through zero."""
    if C[c + COULOMB] == 0.0 and C[c + VISCOUS] == 0.0:
        return 0.0
    return float(C[c + COULOMB] * math.tanh(joint_rate / C[c + SIGN_WIDTH]) + C[c + VISCOUS] * joint_rate)


@compiled
def has_moments(C: np.ndarray, outer: int, inner: int) -> bool:
    """Whether there are moments of either body at `outer` and `inner` in C."""
    total = 0.0
    for k in range(3):
        total += abs(C[outer + k]) + abs(C[inner + k])
    return total > 0.0


@compiled
def gravity_in_base(roll: float, pitch: float) -> tuple[float, float, float]:
    """Gravity (m/s^2) in base axes."""
    (sr, cr), (sp, cp) = sine_cosine(roll), sine_cosine(pitch)
    return GRAVITY_M_S2 * sp, -GRAVITY_M_S2 * cp * sr, -GRAVITY_M_S2 * cp * cr


@compiled
def gravity_torques(
    azimuth: float, elevation: float, gravity: tuple[float, float, float], C: np.ndarray, outer: int, inner: int
) -> tuple[float, float]:
    """Torques (N m) that hold both bodies' unbalance against `gravity` (m/s^2, base axes, an acceleration of the pivot
    taken off).

    The moments (kg m, mass times centre of gravity, in each body's axes) are three numbers each at `outer` and `inner`
    in C.
    """
    (sa, ca), (se, ce) = sine_cosine(azimuth), sine_cosine(elevation)
    bx, by, gz = gravity
    gx, gy = ca * bx + sa * by, ca * by - sa * bx
    # inner moment turned into the outer axes
    ix, iy, iz = C[inner], C[inner + 1], C[inner + 2]
    x, z = ce * ix + se * iz, ce * iz - se * ix
    load_inner = z * gx - x * gz
    load_outer = (C[outer] + x) * gy - (C[outer + 1] + iy) * gx
    return float(-load_outer), float(-load_inner)
