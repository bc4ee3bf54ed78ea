"""A second antenna, for the bench: shares no code with the product (own equations, integrator, friction, sensors, loop).

Fourth-order Runge-Kutta on everything (the product freezes the rate and solves the bristle exactly), mass matrix from
differences of the inverse dynamics. Every effect of CONTRACTS section 6 has a neutral value in the axis' row `A`, so any
combination can be switched on; the last columns are causes that are in no catalogue.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

COLUMNS = [
    *("Ts", "Tc", "vs", "s0", "s1", "s2", "delta", "asym_c", "asym_v", "load_c", "pos_a", "pos_n", "pos_ph", "quad", "temp_b"),
    *("cog_a", "cog_n", "cog_ph", "spring_k", "spring_q0", "res_w", "res_z", "res_share", "gap", "rotor", "gain", "offset", "lag"),
    *("delay", "limit", "emf", "g_bias", "g_scale", "leak_x", "leak_y", "leak_z", "ecc_a", "ecc_ph", "bump_a", "bump_q", "bump_w"),
    *("dead", "hyst_a", "hyst_w", "jump_t", "jump_s2", "cross_c", "cube", "sine_a", "sine_f", "field_a", "field_seed"),
    *("torque_noise", "play_share"),
]
IX = {name: i for i, name in enumerate(COLUMNS)}
(TS, TC, VS, S0, S1, S2, DELTA, ASYM_C, ASYM_V, LOAD_C, POS_A, POS_N, POS_PH, QUAD, TEMP_B, COG_A, COG_N, COG_PH, SPRING_K, SPRING_Q0,
 RES_W, RES_Z, RES_SHARE, GAP, ROTOR, GAIN, OFFSET, LAG, DELAY, LIMIT, EMF, G_BIAS, G_SCALE, LEAK_X, LEAK_Y, LEAK_Z, ECC_A, ECC_PH,
 BUMP_A, BUMP_Q, BUMP_W, DEAD, HYST_A, HYST_W, JUMP_T, JUMP_S2, CROSS_C, CUBE, SINE_A, SINE_F, FIELD_A, FIELD_SEED,
 TORQUE_NOISE, PLAY_SHARE,
 ) = range(len(COLUMNS))  # fmt: skip
#: body row: xx yy zz xy xz yz cx cy cz mass
GRAVITY = 9.81
NS = 14  # q q v v z z lag lag y y yd yd | rotor angle, rotor rate live in extra slots below
SUBSTEPS = 8


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
def _turn_z(a, v):
    c, s = math.cos(a), math.sin(a)
    return (c * v[0] + s * v[1], -s * v[0] + c * v[1], v[2])


@njit(cache=True, error_model="numpy")
def _turn_y(a, v):
    c, s = math.cos(a), math.sin(a)
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
def inverse_dynamics(kind, BO, BI, q0, q1, v0, v1, a0, a1, wb, ab, gb):
    """Torques that the motion needs, the two bodies' rates, and the inertial accelerations about both axes."""
    if kind == 1:  # rotary, horizontal axis
        weight = BO[9] * GRAVITY * (BO[6] * math.cos(q0) - BO[7] * math.sin(q0))
        return BO[2] * a0 + weight, 0.0, (0.0, 0.0, v0), (0.0, 0.0, 0.0), a0, 0.0
    if kind == 2:
        return BO[9] * a0, 0.0, (0.0, 0.0, v0), (0.0, 0.0, 0.0), a0, 0.0
    w = _turn_z(q0, wb)
    al = _turn_z(q0, ab)
    wo = (w[0], w[1], w[2] + v0)
    x = _cross(w, (0.0, 0.0, v0))
    ao = (al[0] + x[0], al[1] + x[1], al[2] + a0)
    go = _turn_z(q0, gb)
    w = _turn_y(q1, wo)
    al = _turn_y(q1, ao)
    wi = (w[0], w[1] + v1, w[2])
    x = _cross(w, (0.0, v1, 0.0))
    ai = (al[0] + x[0], al[1] + a1, al[2] + x[2])
    mi = _moment(BI, wi, ai, _turn_y(q1, go))
    mo = _moment(BO, wo, ao, go)
    back = _turn_y(-q1, mi)
    return mo[2] + back[2], mi[1], wo, wi, ao[2], ai[1]


@njit(cache=True, error_model="numpy")
def _swing(M, i, t, grow, dgrow):
    w = 2.0 * math.pi * M[i, 2]
    s = math.sin(w * t + M[i, 3])
    return M[i, 0] + M[i, 1] * grow * s, M[i, 1] * (dgrow * s + grow * w * math.cos(w * t + M[i, 3]))


@njit(cache=True, error_model="numpy")
def base_state(M, t):
    """Attitude, body rate and gravity in base axes from sinusoids with a smooth start; M rows: offset, amplitude, frequency, phase."""
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


@njit(cache=True, error_model="numpy")
def _level(A, v):
    return A[TC] + (A[TS] - A[TC]) * math.exp(-((abs(v) / A[VS]) ** A[DELTA]))


@njit(cache=True, error_model="numpy")
def friction(A, q, v, z, applied, t, temperature, other):
    """Opposing torque and bristle rate with every friction effect of the row."""
    g = _level(A, v)
    sgn = 1.0 if v > 0 else (-1.0 if v < 0 else 0.0)
    g = (g * (1.0 + A[ASYM_C] * sgn)) * (1.0 + A[POS_A] * math.cos(A[POS_N] * q + A[POS_PH])) + A[LOAD_C] * abs(applied)
    zd = v - A[S0] * abs(v) / g * z
    s2 = A[S2] * (1.0 + A[ASYM_V] * sgn) * math.exp(-A[TEMP_B] * (temperature - 20.0))
    if A[JUMP_T] > 0.0 and t > A[JUMP_T]:
        s2 += A[JUMP_S2]
    return A[S0] * z + A[S1] * zd + s2 * v + A[QUAD] * v * abs(v) + A[CUBE] * v * v * v + A[CROSS_C] * other * other * sgn, zd


@njit(cache=True, error_model="numpy")
def _field(A, q):
    s = 0.0
    for k in range(7):
        n = 0.7 + 1.618 * (k + 1) + 0.31 * math.sin(A[FIELD_SEED] * (k + 1.3))
        s += math.sin(n * q + 2.0 * A[FIELD_SEED] * (k + 2.1)) / math.sqrt(k + 1.0)
    return A[FIELD_A] * s


@njit(cache=True, error_model="numpy")
def _joint_torque(A, q, v, t, applied):
    """Torques at the joint beside friction: position fields, springs, and causes outside the catalogue."""
    s = applied + A[COG_A] * math.sin(A[COG_N] * q + A[COG_PH]) - A[SPRING_K] * (q - A[SPRING_Q0])
    if A[BUMP_A] != 0.0:
        s += A[BUMP_A] * math.exp(-0.5 * ((q - A[BUMP_Q]) / A[BUMP_W]) ** 2)
    s += A[SINE_A] * math.sin(2.0 * math.pi * A[SINE_F] * t)
    if A[FIELD_A] != 0.0:
        s += _field(A, q)
    return s


@njit(cache=True, error_model="numpy")
def _clip(x, lim):
    return min(max(x, -lim), lim)


@njit(cache=True, error_model="numpy")
def derivative(kind, AX, BO, BI, base, x, cmd, t, temperature, out):
    """State: 0-1 q, 2-3 v, 4-5 z, 6-7 lagged torque, 8-9 y, 10-11 y', 12-13 rotor angle, 14-15 rotor rate, 16-17 hysteresis."""
    wb, ab, gb = base
    n0, n1, wo, wi, c0, c1 = inverse_dynamics(kind, BO, BI, x[0], x[1], x[2], x[3], 0.0, 0.0, wb, ab, gb)
    e0, _, _, _, _, _ = inverse_dynamics(kind, BO, BI, x[0], x[1], x[2], x[3], 1.0, 0.0, wb, ab, gb)
    f0, f1, _, _, _, _ = inverse_dynamics(kind, BO, BI, x[0], x[1], x[2], x[3], 0.0, 1.0, wb, ab, gb)
    m00, m01, m11 = e0 - n0, f0 - n0, f1 - n1
    if kind != 0:
        m11 = 1.0
    axes = 2 if kind == 0 else 1
    rhs, dm = out[18:20], out[20:22]
    rhs[:] = 0.0
    dm[:] = 0.0
    for a in range(axes):
        A = AX[a]
        q, v, other = x[a], x[2 + a], x[3 - a]
        u = (1.0 + A[GAIN]) * cmd[a] + A[OFFSET] - A[EMF] * v
        if A[DEAD] > 0.0:
            u = u - _clip(u, A[DEAD])
        if A[LAG] > 0.0:
            out[6 + a] = (u - x[6 + a]) / A[LAG]
            u = x[6 + a]
        else:
            out[6 + a] = 0.0
        u = _clip(u, A[LIMIT])
        drive = u
        out[12 + a] = 0.0
        out[14 + a] = 0.0
        if A[GAP] > 0.0:
            r = x[12 + a] - q
            over = r - _clip(r, 0.5 * A[GAP])
            kc = A[ROTOR] * 500.0**2
            contact = 0.0
            if over != 0.0:
                contact = kc * over + A[ROTOR] * 250.0 * (x[14 + a] - v)
                if contact * over < 0.0:
                    contact = 0.0
            # the rotor turns about the joint's axis and is carried by the base like the joint; of the joint's inertia its share is not
            carried = c0 if a == 0 else c1
            out[12 + a] = x[14 + a]
            out[14 + a] = (u - contact) / A[ROTOR] - carried
            drive = contact
            dm[a] -= A[PLAY_SHARE] * A[ROTOR]
            rhs[a] += A[PLAY_SHARE] * A[ROTOR] * carried
        F, zd = friction(A, q, v, x[4 + a], u, t, temperature[a], other)
        out[4 + a] = zd
        if A[HYST_A] > 0.0:  # an elastic-plastic torque of fixed width
            out[16 + a] = (v - abs(v) * x[16 + a]) / A[HYST_W]
            F += A[HYST_A] * x[16 + a]
        else:
            out[16 + a] = 0.0
        rhs[a] += _joint_torque(A, q, v, t, drive) - F - (n0 if a == 0 else n1)
        out[8 + a] = 0.0
        out[10 + a] = 0.0
        if A[RES_SHARE] > 0.0:
            inertia = (m00 if a == 0 else m11) * A[RES_SHARE]
            spring = inertia * A[RES_W] * (A[RES_W] * x[8 + a] + 2.0 * A[RES_Z] * x[10 + a])
            rhs[a] += spring + inertia * (c0 if a == 0 else c1)
            dm[a] -= inertia
            out[8 + a] = x[10 + a]
            out[10 + a] = -A[RES_W] * (A[RES_W] * x[8 + a] + 2.0 * A[RES_Z] * x[10 + a]) - (c0 if a == 0 else c1)
    k00, k11 = m00 + dm[0], m11 + dm[1]
    det = k00 * k11 - m01 * m01
    acc0 = (k11 * rhs[0] - m01 * rhs[1]) / det
    acc1 = (k00 * rhs[1] - m01 * rhs[0]) / det if axes == 2 else 0.0
    out[0], out[1], out[2], out[3] = x[2], x[3] if axes == 2 else 0.0, acc0, acc1
    out[10] -= acc0 if AX[0, RES_SHARE] > 0.0 else 0.0
    if axes == 2 and AX[1, RES_SHARE] > 0.0:
        out[11] -= acc1
    return wo, wi


@njit(cache=True, error_model="numpy")
def simulate(kind, AX, NOM, BO, BI, BON, BIN, M, ref, heat, gains, sensors, seed, dt, use_gyro):
    """Closed loop. `ref` (n, 2, 3): position, rate, acceleration; `heat` (n, 2) degC; `gains` (2, 5): kp, rate kp, rate ki,
    inertia for feed-forward, torque limit; `sensors` (2, 3): encoder step, gyro noise, encoder noise.

    Answers rows: u0 u1 q0 q1 g0 g1 roll pitch yaw p q r, torque applied 0 1, what the nominal antenna lacks 0 1, true q 0 1.
    """
    np.random.seed(seed)
    n = ref.shape[0]
    axes = 2 if kind == 0 else 1
    out = np.zeros((n, 18))
    x = np.zeros(18)
    k1, k2, k3, k4 = np.zeros(22), np.zeros(22), np.zeros(22), np.zeros(22)
    y = np.zeros(18)
    nominal_z = np.zeros(2)
    moving = M[0, 1] != 0.0 or M[1, 1] != 0.0 or M[2, 1] != 0.0
    lack, applied = np.zeros(2), np.zeros(2)
    for a in range(axes):
        x[a] = ref[0, a, 0]
        x[12 + a] = x[a]
    integral = np.zeros(2)
    rate_lp = np.zeros(2)
    last_q = np.zeros(2)
    cmd = np.zeros(2)
    h = dt / SUBSTEPS
    for k in range(n):
        t = k * dt
        e, wb, _ = base_state(M, t)
        now = base_full(M, moving, t)
        wo, wi = derivative(kind, AX, BO, BI, now, x, cmd, t, heat[k], k1)
        for a in range(axes):
            A = AX[a]
            q = x[a] + A[ECC_A] * math.sin(x[a] + A[ECC_PH]) + sensors[a, 2] * np.random.normal()
            if sensors[a, 0] > 0.0:
                q = round(q / sensors[a, 0]) * sensors[a, 0]
            if kind == 0:
                w = wo[2] if a == 0 else wi[1]
                side = A[LEAK_X] * wo[0] + A[LEAK_Y] * wo[1] if a == 0 else A[LEAK_X] * wi[0] + A[LEAK_Z] * wi[2]
            else:
                w, side = x[2 + a], 0.0
            g = (1.0 + A[G_SCALE]) * w + side + A[G_BIAS] + sensors[a, 1] * np.random.normal()
            if k == 0:
                last_q[a] = q
            rate_lp[a] += 0.35 * ((q - last_q[a]) / dt - rate_lp[a])
            last_q[a] = q
            rate = g if use_gyro else rate_lp[a]
            want = ref[k, a, 1] + gains[a, 0] * (ref[k, a, 0] - q)
            err = want - rate
            u = gains[a, 1] * err + integral[a] + gains[a, 3] * ref[k, a, 2]
            lim = gains[a, 4]
            if abs(u) < lim:
                integral[a] += gains[a, 2] * err * dt
            out[k, a] = _clip(u, lim)
            out[k, 2 + a], out[k, 4 + a] = q, g
            out[k, 16 + a] = x[a]
        for i in range(3):
            out[k, 6 + i], out[k, 9 + i] = e[i], wb[i]
        lack[:] = 0.0
        applied[:] = 0.0
        noise0, noise1 = AX[0, TORQUE_NOISE] * np.random.normal(), AX[1, TORQUE_NOISE] * np.random.normal()
        for s in range(SUBSTEPS):
            ts = t + s * h
            for a in range(axes):
                # the share of this substep that each held value covers, so that any delay is met exactly
                pos = (ts - AX[a, DELAY]) / dt
                row = int(math.floor(pos + 1e-9))
                part = min(1.0, (row + 1 - pos) * dt / h)
                older = out[row, a] if row >= 0 else 0.0
                newer = out[min(row + 1, k), a] if row + 1 >= 0 else 0.0
                cmd[a] = part * older + (1.0 - part) * newer
            cmd[0] += noise0
            cmd[1] += noise1
            mid, end = (base_full(M, moving, ts + 0.5 * h), base_full(M, moving, ts + h)) if moving else (now, now)
            derivative(kind, AX, BO, BI, now, x, cmd, ts, heat[k], k1)
            for i in range(18):
                y[i] = x[i] + 0.5 * h * k1[i]
            derivative(kind, AX, BO, BI, mid, y, cmd, ts + 0.5 * h, heat[k], k2)
            for i in range(18):
                y[i] = x[i] + 0.5 * h * k2[i]
            derivative(kind, AX, BO, BI, mid, y, cmd, ts + 0.5 * h, heat[k], k3)
            for i in range(18):
                y[i] = x[i] + h * k3[i]
            derivative(kind, AX, BO, BI, end, y, cmd, ts + h, heat[k], k4)
            need = inverse_dynamics(kind, BON, BIN, x[0], x[1], x[2], x[3], k1[2], k1[3], now[0], now[1], now[2])
            now = end
            for a in range(axes):
                F, _ = friction(NOM[a], x[a], x[2 + a], nominal_z[a], 0.0, 0.0, 20.0, 0.0)
                decay = NOM[a, S0] * abs(x[2 + a]) / _level(NOM[a], x[2 + a])
                grow = -math.expm1(-decay * h) / decay if decay > 1e-9 else h
                nominal_z[a] += (x[2 + a] - decay * nominal_z[a]) * grow
                lack[a] += (out[k, a] - (need[0] if a == 0 else need[1]) - F) / SUBSTEPS
                u = (1.0 + AX[a, GAIN]) * cmd[a] + AX[a, OFFSET] - AX[a, EMF] * x[2 + a]
                applied[a] += _clip(x[6 + a] if AX[a, LAG] > 0.0 else u, AX[a, LIMIT]) / SUBSTEPS
            for i in range(18):
                x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
        for a in range(axes):
            out[k, 12 + a], out[k, 14 + a] = applied[a], lack[a]
    return out
