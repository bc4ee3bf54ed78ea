"""What each name of the catalogue would do to the torque, as columns over a measured motion, for rivals that regress.

Small changes only: a name whose effect is no torque in proportion to a number has its derivative at zero. Sensor errors
are columns of a second equation, gyro rate minus encoder rate.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.benchmarks.naming.tables import motion_of, read_csv, smooth

Array = np.ndarray
#: of ripples; friction and cogging of other orders are not looked for
ORDERS = range(1, 37)
FRICTION_ORDERS = range(1, 13)


@dataclass(frozen=True)
class Log:
    """One log of a case: raw columns by name, filtered motion (n, axes) and what stands in no model, (n, axes)."""

    raw: dict[str, Array]
    position: Array
    rate: Array
    acceleration: Array
    #: filtered torque minus the known model's; None of a challenge
    lack: Array | None
    #: gyro minus what the encoders and the base say; None without a gyro
    rate_error: Array | None


@dataclass(frozen=True)
class Case:
    """A case as read from its folder."""

    about: dict
    measured: tuple[Log, Log]
    challenge: Log

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes, outer first."""
        return tuple(self.about["axes"])


def read_case(folder: Path) -> Case:
    """Everything that a tool is told of a case."""
    about = json.loads((folder / "case.json").read_text())
    logs = [_log(folder / f"{name}.csv", about) for name in ("measured_0", "measured_1", "challenge")]
    return Case(about, (logs[0], logs[1]), logs[2])


def _log(path: Path, about: dict) -> Log:
    raw, axes, step_s = read_csv(path), tuple(about["axes"]), about["step_s"]
    position, rate, acceleration = motion_of(raw, axes, step_s)
    lack = error = None
    if f"{axes[0]}.torque_filtered" in raw:
        lack = np.stack([raw[f"{axis}.torque_filtered"] - raw[f"{axis}.torque_model"] for axis in axes], axis=1)
    if f"{axes[0]}.rate" in raw:
        gyro = smooth(np.stack([raw[f"{axis}.rate"] for axis in axes], axis=1), step_s)
        turning = np.stack([_turning(raw, position, rate, k)[2 - k] for k in range(len(axes))], axis=1)
        error = gyro - smooth(turning, step_s)
    return Log(raw, position, rate, acceleration, lack, error)


def _turning(raw: dict[str, Array], position: Array, rate: Array, axis: int) -> Array:
    """Body rates (3, n) of an axis' body by encoders and base: outer x, y, z or inner x, y, z."""
    p, q, r = (raw.get(f"base.{name}", np.zeros(len(rate))) for name in "pqr")
    c, s = np.cos(position[:, 0]), np.sin(position[:, 0])
    outer = np.stack([c * p + s * q, -s * p + c * q, r + rate[:, 0]])
    if axis == 0:
        return outer
    c, s = np.cos(position[:, 1]), np.sin(position[:, 1])
    return np.stack([c * outer[0] - s * outer[2], outer[1] + rate[:, 1], s * outer[0] + c * outer[2]])


def own_turning(log: Log, axis: int) -> Array:
    """Body rate about an axis by encoders and base, (n,)."""
    return _turning(log.raw, log.position, log.rate, axis)[2 - axis]


def torque_columns(case: Case, log: Log, axis: int) -> dict[str, list[Array]]:
    """Columns of each name that acts in the torque of an axis; ripples have one name for each order, `cogging#7`."""
    name, step_s = case.axes[axis], case.about["step_s"]
    law = case.about["friction"][name]
    inertia = case.about["inertia"][axis]
    q, v, a = log.position[:, axis], log.rate[:, axis], log.acceleration[:, axis]
    # a challenge has no torque: what the model says of it stands for it
    u = log.raw.get(f"{name}.torque_filtered", log.raw[f"{name}.torque_model"])
    slope, sign = np.gradient(u, step_s), np.tanh(v / law["vs"])
    bump = np.exp(-((np.abs(v) / law["vs"]) ** law["delta"]))
    friction = sign * (law["Tc"] + (law["Ts"] - law["Tc"]) * bump) + law["s2"] * v
    # a bristle that is softer turns round later
    late = np.gradient(sign, step_s) * law["Tc"] ** 2 / law["s0"] / (np.abs(v) + law["vs"])
    warm = log.raw.get(f"{name}.temperature")
    gravity = _gravity(log, axis)
    found = {
        "viscous": [v],
        "coulomb": [sign],
        "stribeck": [sign * bump, sign * np.exp(-((np.abs(v) / (3.0 * law["vs"])) ** 2))],
        "presliding": [late],
        "coulomb_asymmetry": [np.abs(sign)],
        "viscous_asymmetry": [np.abs(v)],
        "load_dependent_friction": [np.abs(u) * sign],
        "quadratic_drag": [v * np.abs(v)],
        "inertia": [a],
        "cable_spring": [q, np.ones_like(q)],
        "torque_gain": [u],
        "torque_offset": [np.ones_like(q)],
        "actuator_lag": [slope],
        "transport_delay": [slope],
        "structural_resonance": [np.gradient(np.gradient(a, step_s), step_s)],
        "backlash": [_play(u, 0.3 * float(np.std(u)))],
        "saturation": [np.sign(u) * np.maximum(np.abs(u) - 0.8 * float(np.abs(u).max()), 0.0)],
        "static_unbalance": gravity,
        "dynamic_unbalance": _products(log, axis),
        "encoder_eccentricity": [
            inertia * (np.cos(q) * a - np.sin(q) * v * v),
            inertia * (np.sin(q) * a + np.cos(q) * v * v),
        ],
    }
    if warm is not None:
        found["temperature_viscosity"] = [v * (smooth(warm, step_s) - 20.0)]
    for order in ORDERS:
        found[f"cogging#{order}"] = [np.sin(order * q), np.cos(order * q)]
    for order in FRICTION_ORDERS:
        found[f"position_dependent_friction#{order}"] = [
            (friction - law["s2"] * v) * np.sin(order * q),
            (friction - law["s2"] * v) * np.cos(order * q),
        ]
    return {name: [smooth(column, step_s) for column in columns] for name, columns in found.items()}


def rate_columns(case: Case, log: Log, axis: int) -> dict[str, list[Array]]:
    """Columns of each name that acts in the gyro minus encoder rate of an axis."""
    q, v = log.position[:, axis], log.rate[:, axis]
    x, y, z = _turning(log.raw, log.position, log.rate, axis)
    own, others = (z, [x, y]) if axis == 0 else (y, [x, z])
    found = {
        "gyro_bias": [np.ones_like(v)],
        "gyro_scale": [own],
        "gyro_misalignment": others,
        "encoder_eccentricity": [v * np.cos(q), v * np.sin(q)],
    }
    return {name: [smooth(column, case.about["step_s"]) for column in columns] for name, columns in found.items()}


def _gravity(log: Log, axis: int) -> list[Array]:
    """Weight of a centre of mass along each of two directions of the body about its axis."""
    roll, pitch = (log.raw.get(f"base.{name}", np.zeros(len(log.rate))) for name in ("roll", "pitch"))
    base = np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)])
    c, s = np.cos(log.position[:, 0]), np.sin(log.position[:, 0])
    x, y, z = c * base[0] + s * base[1], -s * base[0] + c * base[1], base[2]
    if axis == 0:
        return [part for part in (x, y) if np.std(part) > 1e-9] or [x]
    c, s = np.cos(log.position[:, 1]), np.sin(log.position[:, 1])
    return [c * x - s * z, s * x + c * z]


def _products(log: Log, axis: int) -> list[Array]:
    """Torques of two products of inertia, of the rates alone."""
    x, y, z = _turning(log.raw, log.position, log.rate, axis)
    return [x * z, y * z] if axis == 0 else [x * x - z * z, x * y]


def _play(signal: Array, width: float) -> Array:
    """What a play of this width takes off a signal."""
    out, at = np.zeros_like(signal), 0.0
    for k, value in enumerate(signal):
        at = min(max(at, value - width), value + width)
        out[k] = value - at
    return out
