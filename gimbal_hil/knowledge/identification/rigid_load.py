"""The part of the torque that the rigid body needs along a measured motion: gravity, base motion and the other axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimbal_hil.data.signals import RigidBody, SignalsTable
from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.axis_motion import centred_torque
from sim_backend.model import AntennaModel

#: seconds over which a rate is taken from the encoder, for the velocity-dependent part of the load
_RATE_SPAN_S = 0.02


@dataclass(frozen=True)
class AxisLoad:
    """Torques of one axis along the measured motion, each (n,), and the axis' own inertia there (mean over the rows).

    `friction` is the applied torque at t_k minus what gravity, base and the other axis take: friction plus own inertia
    times acceleration. `drive` is the same held over [t_k, t_k+1), for simulation. `held` is the applied torque alone,
    `bias` the rest, sampled at t_k.
    """

    friction: Vector
    drive: Vector
    inertia: float
    held: Vector
    bias: Vector


def axis_load(table: SignalsTable, model: AntennaModel, axis: str) -> AxisLoad:
    """Load of one axis over all rows of a table; the joint rate comes from the encoder, the base from its columns
    (absent: level, fixed).

    Friction acts on the joint, so nothing here touches the gyro. The commanded torque goes through the model's actuator
    (gain, offset, lag, limit) first.
    """
    positions = np.column_stack([table.position(name) for name in model.axes])
    rates = np.column_stack([joint_rate(table.position(name), table.period_s) for name in model.axes])
    body = RigidBody(model).along(table, positions, rates)
    index = model.axes.index(axis)
    bias, inertia = body.bias[:, index], float(np.mean(body.mass[:, 2 * index]))
    if len(model.axes) > 1:
        other = 1 - index
        # the other axis' acceleration reaches this one through the inner body's products of inertia
        bias = bias - body.mass[:, 1] * np.gradient(rates[:, other], table.period_s)
    held = applied_torque(table.torque(axis), model, axis, table.period_s)
    middle = np.concatenate([0.5 * (bias[1:] + bias[:-1]), bias[-1:]])
    return AxisLoad(centred_torque(held) + bias, held + middle, inertia, held, bias)


def applied_torque(command: Vector, model: AntennaModel, axis: str, period_s: float) -> Vector:
    """Torque at the joint for a commanded one, both (n,) and held over the sample: gain, offset, lag (mean over the
    sample), limit.
    """
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
