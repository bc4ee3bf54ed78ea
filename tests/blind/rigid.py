"""Rigid bodies and the base of the bench's antenna: torques that a motion needs, from the bodies' own moments (no code
of the product).

A body is the row xx yy zz xy xz yz cx cy cz mass. Kinds: 0 two-axis gimbal, 1 one rotary axis (horizontal), 2 one
linear axis.
"""

from __future__ import annotations

import math

from numba import njit

GRAVITY = 9.81


@njit(cache=True, error_model="numpy")
def _cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@njit(cache=True, error_model="numpy")
def _tensor(B, w):
    return (
        B[0] * w[0] + B[3] * w[1] + B[4] * w[2],
        B[3] * w[0] + B[1] * w[1] + B[5] * w[2],
        B[4] * w[0] + B[5] * w[1] + B[2] * w[2],
    )


@njit(cache=True, error_model="numpy")
def _turn_z(c, s, v):
    return (c * v[0] + s * v[1], -s * v[0] + c * v[1], v[2])


@njit(cache=True, error_model="numpy")
def _turn_y(c, s, v):
    return (c * v[0] - s * v[2], v[1], s * v[0] + c * v[2])


@njit(cache=True, error_model="numpy")
def _moment(B, w, al, g):
    """Moment about the pivot that the body needs from outside other than gravity."""
    h = _tensor(B, w)
    d = _tensor(B, al)
    gyroscopic = _cross(w, h)
    weight = _cross((B[6], B[7], B[8]), (B[9] * g[0], B[9] * g[1], B[9] * g[2]))
    return (d[0] + gyroscopic[0] - weight[0], d[1] + gyroscopic[1] - weight[1], d[2] + gyroscopic[2] - weight[2])


@njit(cache=True, error_model="numpy")
def turned(q0, q1):
    """Cosine and sine of both joint angles."""
    return math.cos(q0), math.sin(q0), math.cos(q1), math.sin(q1)


@njit(cache=True, error_model="numpy")
def inverse_dynamics(kind, BO, BI, cs, v0, v1, a0, a1, wb, ab, gb):
    """Torques that the motion needs, the two bodies' rates, and the inertial accelerations about both axes; `cs` as
    from `turned`.
    """
    c0, s0, c1, s1 = cs
    if kind == 1:  # rotary, horizontal axis
        weight = BO[9] * GRAVITY * (BO[6] * c0 - BO[7] * s0)
        return BO[2] * a0 + weight, 0.0, (0.0, 0.0, v0), (0.0, 0.0, 0.0), a0, 0.0
    if kind == 2:
        return BO[9] * a0, 0.0, (0.0, 0.0, v0), (0.0, 0.0, 0.0), a0, 0.0
    w = _turn_z(c0, s0, wb)
    al = _turn_z(c0, s0, ab)
    wo = (w[0], w[1], w[2] + v0)
    x = _cross(w, (0.0, 0.0, v0))
    ao = (al[0] + x[0], al[1] + x[1], al[2] + a0)
    go = _turn_z(c0, s0, gb)
    w = _turn_y(c1, s1, wo)
    al = _turn_y(c1, s1, ao)
    wi = (w[0], w[1] + v1, w[2])
    x = _cross(w, (0.0, v1, 0.0))
    ai = (al[0] + x[0], al[1] + a1, al[2] + x[2])
    mi = _moment(BI, wi, ai, _turn_y(c1, s1, go))
    mo = _moment(BO, wo, ao, go)
    back = _turn_y(c1, -s1, mi)
    return mo[2] + back[2], mi[1], wo, wi, ao[2], ai[1]


@njit(cache=True, error_model="numpy")
def _swing(M, i, t, grow, dgrow):
    w = 2.0 * math.pi * M[i, 2]
    s = math.sin(w * t + M[i, 3])
    return M[i, 0] + M[i, 1] * grow * s, M[i, 1] * (dgrow * s + grow * w * math.cos(w * t + M[i, 3]))


@njit(cache=True, error_model="numpy")
def base_state(M, t):
    """Attitude, body rate and gravity in base axes from sinusoids with a smooth start; M rows: offset, amplitude,
    frequency, phase.
    """
    decay = math.exp(-((t / 1.5) ** 2))
    grow, dgrow = 1.0 - decay, 2.0 * t / 2.25 * decay
    roll, droll = _swing(M, 0, t, grow, dgrow)
    pitch, dpitch = _swing(M, 1, t, grow, dgrow)
    yaw, dyaw = _swing(M, 2, t, grow, dgrow)
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    w = (droll - dyaw * sp, dpitch * cr + dyaw * sr * cp, -dpitch * sr + dyaw * cr * cp)
    g = (GRAVITY * sp, -GRAVITY * cp * sr, -GRAVITY * cp * cr)
    return (roll, pitch, yaw), w, g


@njit(cache=True, error_model="numpy")
def base_full(M, moving, t):
    """Rate, angular acceleration and gravity of the base in its own axes."""
    _, w, g = base_state(M, t)
    if not moving:
        return w, (0.0, 0.0, 0.0), g
    h = 1e-4
    _, wp, _ = base_state(M, t + h)
    _, wm, _ = base_state(M, t - h)
    return w, ((wp[0] - wm[0]) / (2 * h), (wp[1] - wm[1]) / (2 * h), (wp[2] - wm[2]) / (2 * h)), g
