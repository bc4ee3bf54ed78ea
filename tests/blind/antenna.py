"""A second antenna, for the bench: shares no code with the product (own equations, integrator, friction, sensors,
loop).

Fourth-order Runge-Kutta on everything (the product freezes the rate and solves the bristle exactly), mass matrix from
differences of the inverse dynamics. Every effect of docs/reference/effects.md has a neutral value in the axis' row `A`,
so any combination can be switched on; the last columns are causes that are in no catalogue.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from tests.blind.rigid import base_full, base_state, inverse_dynamics, turned

COLUMNS = [
    *(
        "Ts",
        "Tc",
        "vs",
        "s0",
        "s1",
        "s2",
        "delta",
        "asym_c",
        "asym_v",
        "load_c",
        "pos_a",
        "pos_n",
        "pos_ph",
        "quad",
        "temp_b",
    ),
    *(
        "cog_a",
        "cog_n",
        "cog_ph",
        "spring_k",
        "spring_q0",
        "res_w",
        "res_z",
        "res_share",
        "gap",
        "rotor",
        "gain",
        "offset",
        "lag",
    ),
    *(
        "delay",
        "limit",
        "emf",
        "g_bias",
        "g_scale",
        "leak_x",
        "leak_y",
        "leak_z",
        "ecc_a",
        "ecc_ph",
        "bump_a",
        "bump_q",
        "bump_w",
    ),
    *("dead", "hyst_a", "hyst_w", "jump_t", "jump_s2", "cross_c", "cube", "sine_a", "sine_f", "field_a", "field_seed"),
    *(
        "torque_noise",
        "play_share",
        "hyst_n",
        "stop_k",
        "stop_q",
        "stop_w",
        "snag_a",
        "snag_q",
        "snag_w",
        "grease_a",
        "grease_tau",
    ),
    *(
        "grease_p",
        "dwell_a",
        "slosh_j",
        "slosh_w",
        "slosh_z",
        "leak_t",
        "sub_a",
        "sub_n",
        "sub_ph",
        "visc_a",
        "visc_n",
        "visc_ph",
    ),
    # laws of one variable, for the bench of laws
    *("cubic_k", "edge_k", "edge_q", "detent_a", "detent_q", "detent_w", "fast_a", "fast_v", "hump_a", "hump_v"),
    "snag_one_way",
]
IX = {name: i for i, name in enumerate(COLUMNS)}
(TS, TC, VS, S0, S1, S2, DELTA, ASYM_C, ASYM_V, LOAD_C, POS_A, POS_N, POS_PH, QUAD, TEMP_B, COG_A, COG_N, COG_PH,
SPRING_K, SPRING_Q0,
 RES_W, RES_Z, RES_SHARE, GAP, ROTOR, GAIN, OFFSET, LAG, DELAY, LIMIT, EMF, G_BIAS, G_SCALE, LEAK_X, LEAK_Y, LEAK_Z,
 ECC_A, ECC_PH,
 BUMP_A, BUMP_Q, BUMP_W, DEAD, HYST_A, HYST_W, JUMP_T, JUMP_S2, CROSS_C, CUBE, SINE_A, SINE_F, FIELD_A, FIELD_SEED,
 TORQUE_NOISE, PLAY_SHARE, HYST_N, STOP_K, STOP_Q, STOP_W, SNAG_A, SNAG_Q, SNAG_W, GREASE_A, GREASE_TAU, GREASE_P,
 DWELL_A,
 SLOSH_J, SLOSH_W, SLOSH_Z, LEAK_T, SUB_A, SUB_N, SUB_PH, VISC_A, VISC_N, VISC_PH,
 CUBIC_K, EDGE_K, EDGE_Q, DETENT_A, DETENT_Q, DETENT_W, FAST_A, FAST_V, HUMP_A, HUMP_V, SNAG_ONE_WAY,
 ) = range(len(COLUMNS))  # fmt: skip
#: what varies by itself, per sample and axis: factor on all friction, torque added (N m), factor on the drive's torque
LEVEL, DRIFT, DRIVE = range(3)
STILL = (1.0, 0.0, 1.0)
NS = 22  # states, see derivative; four more slots are scratch
SUBSTEP_S = 1.25e-4
#: a lag under it is none: the integrator would not stand it
SHORTEST_LAG_S = 6e-5


@njit(cache=True, error_model="numpy")
def _level(A, v, rested):
    """Friction in sliding, N m; stiction grows with the time that the joint has rested where the row says so."""
    rise = A[DWELL_A] * math.log1p(20.0 * rested) if A[DWELL_A] != 0.0 else 0.0
    return A[TC] + (A[TS] + rise - A[TC]) * math.exp(-((abs(v) / A[VS]) ** A[DELTA]))


@njit(cache=True, error_model="numpy")
def friction(A, q, v, z, applied, t, temperature, other, worked, rested):
    """Opposing torque and bristle rate with every friction effect of the row."""
    g = _level(A, v, rested)
    sgn = 1.0 if v > 0 else (-1.0 if v < 0 else 0.0)
    g = g * (1.0 + A[ASYM_C] * sgn)
    if A[POS_A] != 0.0:
        g *= 1.0 + A[POS_A] * math.cos(A[POS_N] * q + A[POS_PH])
    g += A[LOAD_C] * abs(applied)
    zd = v - A[S0] * abs(v) / g * z
    s2 = A[S2] * (1.0 + A[ASYM_V] * sgn)
    if A[TEMP_B] != 0.0:
        s2 *= math.exp(-A[TEMP_B] * (temperature - 20.0))
    if A[VISC_A] != 0.0:
        s2 *= 1.0 + A[VISC_A] * math.cos(A[VISC_N] * q + A[VISC_PH])
    if (
        A[GREASE_A] != 0.0
    ):  # fresh grease is stiffer than worked grease; halfway between is what the row's viscous friction says
        s2 += A[GREASE_A] * (math.exp(-worked) - 0.5)
    if A[JUMP_T] > 0.0 and t > A[JUMP_T]:
        s2 += A[JUMP_S2]
    F = A[S0] * z + A[S1] * zd + s2 * v + A[QUAD] * v * abs(v) + A[CUBE] * v * v * v + A[CROSS_C] * other * other * sgn
    if A[FAST_A] != 0.0:  # rises to its level with the speed
        F += A[FAST_A] * sgn * (1.0 - math.exp(-abs(v) / A[FAST_V]))
    if A[HUMP_A] != 0.0:  # tightest at one speed
        F += A[HUMP_A] * sgn * math.exp(-0.5 * ((abs(v) - A[HUMP_V]) / (0.3 * A[HUMP_V])) ** 2)
    if A[SNAG_A] != 0.0 and (A[SNAG_ONE_WAY] == 0.0 or v > 0.0):
        F += A[SNAG_A] * math.exp(-0.5 * ((q - A[SNAG_Q]) / A[SNAG_W]) ** 2) * math.tanh(50.0 * v)
    return F, zd


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
    s = applied - A[SPRING_K] * (q - A[SPRING_Q0])
    if A[COG_A] != 0.0:
        s += A[COG_A] * math.sin(A[COG_N] * q + A[COG_PH])
    if A[BUMP_A] != 0.0:
        s += A[BUMP_A] * math.exp(-0.5 * ((q - A[BUMP_Q]) / A[BUMP_W]) ** 2)
    if A[STOP_K] != 0.0:  # soft at first touch, harder the deeper
        deep = (abs(q - A[STOP_Q]) - A[STOP_W]) / 0.1
        if deep > 0.0:
            s -= math.copysign(A[STOP_K] * 0.1 * (deep * deep + deep * deep * deep), q - A[STOP_Q])
    if A[CUBIC_K] != 0.0:
        s -= A[CUBIC_K] * q * q * q
    if A[EDGE_K] != 0.0 and q > A[EDGE_Q]:
        s -= A[EDGE_K] * (q - A[EDGE_Q])
    if A[DETENT_A] != 0.0:
        u = (q - A[DETENT_Q]) / A[DETENT_W]
        s -= A[DETENT_A] * u * math.exp(0.5 - 0.5 * u * u)
    if A[SINE_A] != 0.0:
        s += A[SINE_A] * math.sin(2.0 * math.pi * A[SINE_F] * t)
    if A[FIELD_A] != 0.0:
        s += _field(A, q)
    return s


@njit(cache=True, error_model="numpy")
def _clip(x, lim):
    return min(max(x, -lim), lim)


@njit(cache=True, error_model="numpy")
def derivative(kind, AX, BO, BI, base, x, cmd, t, temperature, weather, out):
    """State: 0-1 q, 2-3 v, 4-5 z, 6-7 lagged torque, 8-9 y, 10-11 y', 12-13 rotor angle, 14-15 rotor rate, 16-17
    hysteresis, 18-19 recent work on the grease, 20-21 time at rest; `out` has four slots more for scratch.
    """
    wb, ab, gb = base
    cs = turned(x[0], x[1])
    n0, n1, wo, wi, c0, c1 = inverse_dynamics(kind, BO, BI, cs, x[2], x[3], 0.0, 0.0, wb, ab, gb)
    e0, _, _, _, _, _ = inverse_dynamics(kind, BO, BI, cs, x[2], x[3], 1.0, 0.0, wb, ab, gb)
    f0, f1, _, _, _, _ = inverse_dynamics(kind, BO, BI, cs, x[2], x[3], 0.0, 1.0, wb, ab, gb)
    m00, m01, m11 = e0 - n0, f0 - n0, f1 - n1
    if kind != 0:
        m11 = 1.0
    axes = 2 if kind == 0 else 1
    rhs, dm = out[22:24], out[24:26]
    rhs[:] = 0.0
    dm[:] = 0.0
    for a in range(axes):
        A = AX[a]
        q, v, other = x[a], x[2 + a], x[3 - a]
        u = (1.0 + A[GAIN]) * cmd[a] + A[OFFSET] - A[EMF] * v
        if A[DEAD] > 0.0:
            u = u - _clip(u, A[DEAD])
        u *= weather[a, DRIVE]
        if A[LAG] > SHORTEST_LAG_S:
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
            # the rotor turns about the joint's axis and is carried by the base like the joint; of the joint's inertia
            # its share is not
            carried = c0 if a == 0 else c1
            out[12 + a] = x[14 + a]
            out[14 + a] = (u - contact) / A[ROTOR] - carried
            drive = contact
            dm[a] -= A[PLAY_SHARE] * A[ROTOR]
            rhs[a] += A[PLAY_SHARE] * A[ROTOR] * carried
        F, zd = friction(A, q, v, x[4 + a], u, t, temperature[a], other, x[18 + a], x[20 + a])
        F *= weather[a, LEVEL]
        out[4 + a] = zd
        out[18 + a] = (F * v / A[GREASE_P] - x[18 + a]) / A[GREASE_TAU] if A[GREASE_A] != 0.0 else 0.0
        out[20 + a] = math.exp(-((v / 1e-3) ** 2)) - abs(v) / 5e-3 * x[20 + a] if A[DWELL_A] != 0.0 else 0.0
        if (
            A[HYST_A] > 0.0
        ):  # an elastic-plastic torque of fixed width: Dahl's, or Bouc and Wen's with a softer shoulder
            z = x[16 + a]
            if A[HYST_N] > 0.0:
                give = abs(z) ** A[HYST_N] * (0.7 * math.copysign(v, z) + 0.3 * v)
            else:
                give = abs(v) * z
            out[16 + a] = (v - give) / A[HYST_W]
            F += A[HYST_A] * x[16 + a]
        else:
            out[16 + a] = 0.0
        rhs[a] += (
            _joint_torque(A, q, v, t, drive) - F - (n0 if a == 0 else n1) + weather[a, DRIFT] + A[LEAK_T] * cmd[1 - a]
        )
        out[8 + a] = 0.0
        out[10 + a] = 0.0
        if A[RES_SHARE] > 0.0:
            inertia = (m00 if a == 0 else m11) * A[RES_SHARE]
            spring = inertia * A[RES_W] * (A[RES_W] * x[8 + a] + 2.0 * A[RES_Z] * x[10 + a])
            rhs[a] += spring + inertia * (c0 if a == 0 else c1)
            dm[a] -= inertia
            out[8 + a] = x[10 + a]
            out[10 + a] = -A[RES_W] * (A[RES_W] * x[8 + a] + 2.0 * A[RES_Z] * x[10 + a]) - (c0 if a == 0 else c1)
        if (
            A[SLOSH_J] > 0.0
        ):  # a mass on top of the body, on a slow spring in a liquid; `carried` by the base like the joint
            thick = 2.0 * A[SLOSH_Z] * (A[SLOSH_W] + 4.0 * abs(x[10 + a]))
            pull = A[SLOSH_W] * A[SLOSH_W] * x[8 + a] + thick * x[10 + a]
            rhs[a] += A[SLOSH_J] * pull
            out[8 + a] = x[10 + a]
            out[10 + a] = -pull - (c0 if a == 0 else c1)
    k00, k11 = m00 + dm[0], m11 + dm[1]
    det = k00 * k11 - m01 * m01
    acc0 = (k11 * rhs[0] - m01 * rhs[1]) / det
    acc1 = (k00 * rhs[1] - m01 * rhs[0]) / det if axes == 2 else 0.0
    out[0], out[1], out[2], out[3] = x[2], x[3] if axes == 2 else 0.0, acc0, acc1
    out[10] -= acc0 if AX[0, RES_SHARE] > 0.0 or AX[0, SLOSH_J] > 0.0 else 0.0
    if axes == 2 and (AX[1, RES_SHARE] > 0.0 or AX[1, SLOSH_J] > 0.0):
        out[11] -= acc1
    return wo, wi


@njit(cache=True, error_model="numpy")
def simulate(kind, AX, NOM, BO, BI, BON, BIN, M, ref, heat, weather, gains, sensors, seed, dt, use_gyro):
    """Closed loop. `ref` (n, 2, 3): position, rate, acceleration; `heat` (n, 2) degC; `weather` (n, 2, 3) as in
    weather.py; `gains` (2, 5): kp, rate kp, rate ki, inertia for feed-forward, torque limit; `sensors` (2, 3): encoder
    step, gyro noise, encoder noise.

    Answers rows: u0 u1 q0 q1 g0 g1 roll pitch yaw p q r, torque applied 0 1, what the nominal antenna lacks 0 1, true q
    0 1.
    """
    np.random.seed(seed)
    n = ref.shape[0]
    axes = 2 if kind == 0 else 1
    out = np.zeros((n, 18))
    x = np.zeros(NS)
    k1, k2, k3, k4 = np.zeros(NS + 4), np.zeros(NS + 4), np.zeros(NS + 4), np.zeros(NS + 4)
    y = np.zeros(NS)
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
    substeps = max(1, int(round(dt / SUBSTEP_S)))
    h = dt / substeps
    for k in range(n):
        t = k * dt
        e, wb, _ = base_state(M, t)
        now = base_full(M, moving, t)
        wo, wi = derivative(kind, AX, BO, BI, now, x, cmd, t, heat[k], weather[k], k1)
        for a in range(axes):
            A = AX[a]
            fine = A[SUB_A] * math.sin(A[SUB_N] * x[a] + (A[SUB_PH] if x[2 + a] > 0.0 else -A[SUB_PH]))
            q = x[a] + A[ECC_A] * math.sin(x[a] + A[ECC_PH]) + fine + sensors[a, 2] * np.random.normal()
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
        for s in range(substeps):
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
            derivative(kind, AX, BO, BI, now, x, cmd, ts, heat[k], weather[k], k1)
            for i in range(NS):
                y[i] = x[i] + 0.5 * h * k1[i]
            derivative(kind, AX, BO, BI, mid, y, cmd, ts + 0.5 * h, heat[k], weather[k], k2)
            for i in range(NS):
                y[i] = x[i] + 0.5 * h * k2[i]
            derivative(kind, AX, BO, BI, mid, y, cmd, ts + 0.5 * h, heat[k], weather[k], k3)
            for i in range(NS):
                y[i] = x[i] + h * k3[i]
            derivative(kind, AX, BO, BI, end, y, cmd, ts + h, heat[k], weather[k], k4)
            need = inverse_dynamics(
                kind, BON, BIN, turned(x[0], x[1]), x[2], x[3], k1[2], k1[3], now[0], now[1], now[2]
            )
            now = end
            for a in range(axes):
                F, _ = friction(NOM[a], x[a], x[2 + a], nominal_z[a], 0.0, 0.0, 20.0, 0.0, 0.0, 0.0)
                decay = NOM[a, S0] * abs(x[2 + a]) / _level(NOM[a], x[2 + a], 0.0)
                grow = -math.expm1(-decay * h) / decay if decay > 1e-9 else h
                nominal_z[a] += (x[2 + a] - decay * nominal_z[a]) * grow
                lack[a] += (out[k, a] - (need[0] if a == 0 else need[1]) - F) / substeps
                u = (1.0 + AX[a, GAIN]) * cmd[a] + AX[a, OFFSET] - AX[a, EMF] * x[2 + a]
                applied[a] += _clip(x[6 + a] if AX[a, LAG] > SHORTEST_LAG_S else u, AX[a, LIMIT]) / substeps
            for i in range(NS):
                x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
        for a in range(axes):
            out[k, 12 + a], out[k, 14 + a] = applied[a], lack[a]
    return out
