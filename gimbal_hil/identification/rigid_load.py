"""What the rigid body takes of the torque along a measured motion: gravity, base motion and the other axis, from the model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from firmware_protocol.compiling import entry_point
from gimbal_hil.identification.averaging import Vector
from gimbal_hil.identification.rigid_axis import centred_torque
from gimbal_hil.signals import SignalsTable
from sim_backend.layout import GRAVITY_M_S2
from sim_backend.model import AntennaModel, plant_arrays
from sim_backend.rigid_body import equations_of_motion

#: seconds over which a rate is taken from the encoder, for the velocity-dependent part of the load
_RATE_SPAN_S = 0.02


@dataclass(frozen=True)
class AxisLoad:
    """Torques of one axis along the measured motion, each (n,), and the axis' own inertia there (mean over the rows).

    `friction` is the applied torque at t_k minus what gravity, base and the other axis take: friction plus own inertia times
    acceleration. `drive` is the same held over [t_k, t_k+1), for simulation.
    """

    friction: Vector
    drive: Vector
    inertia: float


def axis_load(table: SignalsTable, model: AntennaModel, axis: str) -> AxisLoad:
    """Load of one axis over all rows of a table; the joint rate comes from the encoder, the base from its columns (absent: level, fixed).

    Friction acts on the joint, so nothing here touches the gyro. The commanded torque goes through the model's actuator (gain,
    offset, lag, limit) first.
    """
    arrays = plant_arrays(model.with_base({"motion": "fixed"}), 1.0 / model.file.plant_step_s)
    n, axes = len(table), len(model.axes)
    positions, rates = np.zeros((n, 2)), np.zeros((n, 2))
    for index, name in enumerate(model.axes):
        positions[:, index] = table.position(name)
        rates[:, index] = joint_rate(table.position(name), table.period_s)
    base = _base_rows(table, arrays.P[GRAVITY_M_S2])
    out = np.zeros((n, 4))
    _bias(arrays.P, arrays.K, positions, rates, base, out)
    index = model.axes.index(axis)
    bias, inertia = out[:, index], float(np.mean(out[:, 2 + index]))
    if axes > 1:
        other = 1 - index
        # the other axis' acceleration reaches this one through the product of inertia alone, a thousandth of the diagonal
        bias = bias - float(np.mean(_coupling(model))) * np.gradient(rates[:, other], table.period_s)
    held = applied_torque(table.torque(axis), model, axis, table.period_s)
    middle = np.concatenate([0.5 * (bias[1:] + bias[:-1]), bias[-1:]])
    return AxisLoad(centred_torque(held) + bias, held + middle, inertia)


def applied_torque(command: Vector, model: AntennaModel, axis: str, period_s: float) -> Vector:
    """Torque at the joint for a commanded one, both (n,) and held over the sample: gain, offset, lag (mean over the sample), limit."""
    torque = (1.0 + model.number(axis, "actuator.gain_error")) * command + model.number(axis, "actuator.offset")
    lag = model.number(axis, "actuator.time_constant")
    if lag > 0.0:
        decay = float(np.exp(-period_s / lag))
        mean_share = lag / period_s * (1.0 - decay)
        state, out = float(torque[0]), np.empty(len(torque))
        for k, target in enumerate(torque.tolist()):
            out[k] = target + (state - target) * mean_share
            state = target + (state - target) * decay
        torque = out
    limit = model.number(axis, "actuator.limit")
    return np.asarray(np.clip(torque, -limit, limit) if limit > 0.0 else torque)


def joint_rate(position: Vector, period_s: float) -> Vector:
    """Joint rate (n,) from the encoder: central differences over 20 ms, zero-phase."""
    span = max(1, int(round(0.5 * _RATE_SPAN_S / period_s)))
    padded = np.concatenate([np.full(span, position[0]), position, np.full(span, position[-1])])
    return np.asarray((padded[2 * span :] - padded[: -2 * span]) / (2 * span * period_s))


def _coupling(model: AntennaModel) -> float:
    return model.number(model.axes[1], "body.inertia.yz")


def _base_rows(table: SignalsTable, gravity: float) -> np.ndarray:
    """Gravity, rate and angular acceleration of the base in its own axes, (n, 9); one row when the table has no base columns."""
    angles = [table.base(name) for name in ("roll", "pitch")]
    rates = [table.base(name) for name in ("p", "q", "r")]
    if all(column is None for column in (*angles, *rates)):
        return np.array([[0.0, 0.0, -gravity, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
    n = len(table)
    rows = np.zeros((n, 9))
    roll, pitch = (np.zeros(n) if column is None else column for column in angles)
    cos_pitch = np.cos(pitch)
    rows[:, 0], rows[:, 1], rows[:, 2] = gravity * np.sin(pitch), -gravity * cos_pitch * np.sin(roll), -gravity * cos_pitch * np.cos(roll)
    for index, column in enumerate(rates):
        if column is not None:
            rows[:, 3 + index] = column
            rows[:, 6 + index] = np.gradient(column, table.period_s)
    return rows


@entry_point
def _bias(P: np.ndarray, K: np.ndarray, positions: np.ndarray, rates: np.ndarray, base: np.ndarray, out: np.ndarray) -> None:
    for k in range(positions.shape[0]):
        b = base[min(k, base.shape[0] - 1)]
        state = ((b[0], b[1], b[2]), (b[3], b[4], b[5]), (b[6], b[7], b[8]))
        mass, bias, _, _, _ = equations_of_motion(P, K, (positions[k, 0], positions[k, 1]), (rates[k, 0], rates[k, 1]), state)
        out[k, 0], out[k, 1] = bias
        out[k, 2], out[k, 3] = mass[0], mass[2]
