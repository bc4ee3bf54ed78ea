"""What the known model says of a measured motion, so that no tool needs a model of its own to take part.

Rigid bodies by the generator's own equations, and the LuGre bristle carried along the measured joint rate; motion from
the encoder by zero-phase filters, torque by the same filter.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tests.benchmarks.naming.tables import motion_of, smooth
from tests.blind.rig import Rig
from tests.blind.rigid import inverse_dynamics, turned

Array = np.ndarray


def known_torque(columns: dict[str, Array], rig: Rig, step_s: float) -> Array:
    """Torque that the known model needs for the measured motion, (n, axes), N m (N)."""
    position, rate, acceleration = (_two(part) for part in motion_of(columns, rig.names, step_s))
    friction = np.zeros_like(rate)
    for k in range(len(rig.names)):
        number = rig.friction[("outer", "inner")[k]]
        law = np.array([number[key] for key in ("Ts", "Tc", "vs", "s0", "s1", "s2", "delta")])
        friction[:, k] = _carried(rate[:, k], law, step_s)
    base = np.zeros((len(rate), 9))
    for k, name in enumerate(("roll", "pitch", "yaw", "p", "q", "r")):
        if f"base.{name}" in columns:
            base[:, k] = columns[f"base.{name}"]
    base[:, 6:] = np.gradient(base[:, 3:6], step_s, axis=0)
    bodies = rig.bodies["outer"], rig.bodies["inner"]
    rigid = _needed(rig.axes.value, *bodies, position, rate, acceleration, base)
    return smooth(rigid + friction, step_s)[:, : len(rig.names)]


def _two(part: Array) -> Array:
    return part if part.shape[1] == 2 else np.column_stack([part, np.zeros(len(part))])


@njit(cache=True)
def _carried(rate: Array, law: Array, step_s: float) -> Array:
    ts, tc, vs, s0, s1, s2, delta = law
    out, z, within = np.zeros(len(rate)), 0.0, 10
    h = step_s / within
    for k in range(len(rate)):
        v = rate[k]
        level = tc + (ts - tc) * np.exp(-((abs(v) / vs) ** delta))
        total = 0.0
        for _ in range(within):
            before = z
            # exact for a rate that stays over the step
            end = np.sign(v) * level / s0
            z = end + (z - end) * np.exp(-s0 * abs(v) / level * h)
            total += s0 * 0.5 * (z + before) + s1 * (z - before) / h
        out[k] = total / within + s2 * v
    return out


@njit(cache=True)
def _needed(kind: int, outer: Array, inner: Array, q: Array, v: Array, a: Array, base: Array) -> Array:
    out = np.zeros((len(q), 2))
    for k in range(len(q)):
        sr, cr = np.sin(base[k, 0]), np.cos(base[k, 0])
        sp, cp = np.sin(base[k, 1]), np.cos(base[k, 1])
        # down in the axes of the base; heading does not turn it
        down = (9.81 * sp, -9.81 * cp * sr, -9.81 * cp * cr)
        turning = (base[k, 3], base[k, 4], base[k, 5])
        growing = (base[k, 6], base[k, 7], base[k, 8])
        cs = turned(q[k, 0], q[k, 1])
        found = inverse_dynamics(kind, outer, inner, cs, v[k, 0], v[k, 1], a[k, 0], a[k, 1], turning, growing, down)
        out[k, 0], out[k, 1] = found[0], found[1]
    return out
