"""Joint accelerations from a Lagrangian: kinetic and potential energy written down, everything else by sympy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import sympy as sp

from sim_backend.model import AntennaModel


def _rz(a: sp.Expr) -> sp.Matrix:
    return sp.Matrix([[sp.cos(a), -sp.sin(a), 0], [sp.sin(a), sp.cos(a), 0], [0, 0, 1]])


def _ry(a: sp.Expr) -> sp.Matrix:
    return sp.Matrix([[sp.cos(a), 0, sp.sin(a)], [0, 1, 0], [-sp.sin(a), 0, sp.cos(a)]])


def _rx(a: sp.Expr) -> sp.Matrix:
    return sp.Matrix([[1, 0, 0], [0, sp.cos(a), -sp.sin(a)], [0, sp.sin(a), sp.cos(a)]])


def lagrangian_accelerations(model: AntennaModel) -> Callable[[dict[str, np.ndarray]], np.ndarray]:
    """A function from a state (Euler angles yaw, pitch, roll with rates and accelerations, q, v, torque) to
    accelerations (2,).
    """
    x = sp.symbols("yaw pitch roll eta eps")
    d = sp.symbols("dyaw dpitch droll deta deps")
    dd = sp.symbols("ddyaw ddpitch ddroll ddeta ddeps")
    yaw, pitch, roll, eta, eps = x
    base = _rz(yaw) * _ry(pitch) * _rx(roll)
    outer = base * _rz(eta)
    inner = outer * _ry(eps)
    energy = sp.Integer(0)
    for axis, turn in (("outer", outer), ("inner", inner)):
        n = [sp.Float(model.number(axis, f"body.inertia.{k}"), 30) for k in ("xx", "yy", "zz", "xy", "xz", "yz")]
        tensor = sp.Matrix([[n[0], n[3], n[4]], [n[3], n[1], n[5]], [n[4], n[5], n[2]]])
        cog = sp.Matrix([sp.Float(model.number(axis, f"body.cog.{k}"), 30) for k in "xyz"])
        # body rate from R^T dR/dt, entry by entry
        rate = sp.zeros(3, 3)
        for angle, speed in zip(x, d, strict=True):
            rate += turn.T * sp.diff(turn, angle) * speed
        w = sp.Matrix([rate[2, 1], rate[0, 2], rate[1, 0]])
        height = (turn * cog)[2]
        mass = sp.Float(model.number(axis, "body.mass"), 30)
        energy += (w.T * tensor * w)[0] / 2 - mass * sp.Float(model.file.gravity_m_s2, 30) * height
    torque = sp.symbols("t0 t1")
    equations = []
    for i, angle in enumerate((eta, eps)):
        momentum = sp.diff(energy, d[3 + i])
        change = sum(sp.diff(momentum, a) * b for a, b in zip(x, d, strict=True)) + sum(
            sp.diff(momentum, a) * b for a, b in zip(d, dd, strict=True)
        )
        equations.append(change - sp.diff(energy, angle) - torque[i])
    matrix = sp.Matrix([[sp.diff(e, dd[3 + j]) for j in range(2)] for e in equations])
    right = sp.Matrix([-e.subs({dd[3]: 0, dd[4]: 0}) for e in equations])
    compute = sp.lambdify([*x, *d, *dd[:3], *torque], [matrix, right], cse=True)

    def accelerations(state: dict[str, np.ndarray]) -> np.ndarray:
        m, r = compute(
            *state["euler"],
            *state["q"],
            *state["euler_rate"],
            *state["v"],
            *state["euler_acceleration"],
            *state["torque"],
        )
        return np.linalg.solve(np.array(m, dtype=float), np.array(r, dtype=float)).ravel()

    return accelerations
