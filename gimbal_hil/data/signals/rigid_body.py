"""What a model's rigid body asks of its joints along a measured motion: gravity, base motion and the other axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.compiling import entry_point
from gimbal_hil.data.signals.table import SignalsTable
from sim_backend.layout import GRAVITY_M_S2
from sim_backend.model import AntennaModel, plant_arrays
from sim_backend.rigid_body import equations_of_motion

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class RigidMotion:
    """Of each axis of a model along a motion of n rows, in `M q'' = T - F + h`, SI units of its kind.

    `bias` (n, axes) is h: gravity, base motion and rates. `mass` (n, 3) holds M11, M12, M22. `rate` (n, axes) is what a
    gyro on the body sees about its axis.
    """

    bias: Floats
    mass: Floats
    rate: Floats

    def inertial(self, acceleration: Floats) -> Floats:
        """Torque (n, axes) that joint accelerations (n, axes) take of their own and of the other axis."""
        if acceleration.shape[1] == 1:
            return self.mass[:, :1] * acceleration
        own, across = self.mass[:, ::2], self.mass[:, 1:2]
        return np.asarray(own * acceleration + across * acceleration[:, ::-1])


class RigidBody:
    """The rigid body of a model, built once for any number of logs."""

    def __init__(self, model: AntennaModel) -> None:
        self._arrays = plant_arrays(model.with_base({"motion": "fixed"}), 1.0 / model.file.plant_step_s)

    def along(self, table: SignalsTable, positions: Floats, rates: Floats) -> RigidMotion:
        """At joint positions and rates, (n, axes) each, on the base as the table has it (absent: level, fixed)."""
        arrays, axes = self._arrays, positions.shape[1]
        wide = np.zeros((2, len(positions), 2))
        wide[0, :, :axes], wide[1, :, :axes] = positions, rates
        out = np.zeros((len(positions), 7))
        _along(arrays.P, arrays.K, wide[0], wide[1], base_rows(table, float(arrays.P[GRAVITY_M_S2])), out)
        single = axes == 1
        return RigidMotion(out[:, :axes], out[:, 2:5], rates if single else out[:, 5:7])


def base_rows(table: SignalsTable, gravity_m_s2: float) -> Floats:
    """Gravity less the pivot's acceleration, rate and angular acceleration of the base, in its own axes, (n, 9).

    One row when the table has no base columns. Where attitudes were measured and no rates, the rates follow from them.
    """
    columns = {name: table.base(name) for name in ("roll", "pitch", "yaw", "p", "q", "r", "ax", "ay", "az")}
    if all(column is None for column in columns.values()):
        return np.array([[0.0, 0.0, -gravity_m_s2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
    n = len(table)
    known = {name: np.zeros(n) if column is None else column for name, column in columns.items()}
    roll, pitch = known["roll"], known["pitch"]
    down = np.column_stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)])
    measured = any(columns[name] is not None for name in "pqr")
    rate = np.column_stack([known[name] for name in "pqr"]) if measured else body_rates(table)
    pivot = np.column_stack([known[name] for name in ("ax", "ay", "az")])
    return np.column_stack([gravity_m_s2 * down - pivot, rate, np.gradient(rate, table.period_s, axis=0)])


def body_rates(table: SignalsTable) -> Floats:
    """Body rates p, q, r (n, 3) of the base, rad/s, from its attitude alone."""
    n = len(table)
    roll, pitch, yaw = (
        np.zeros(n) if (angle := table.base(name)) is None else angle for name in ("roll", "pitch", "yaw")
    )
    unwrapped = np.unwrap(np.column_stack([roll, pitch, yaw]), axis=0)
    d_roll, d_pitch, d_yaw = np.gradient(unwrapped, table.period_s, axis=0).T
    return np.column_stack(
        [
            d_roll - d_yaw * np.sin(pitch),
            d_pitch * np.cos(roll) + d_yaw * np.sin(roll) * np.cos(pitch),
            -d_pitch * np.sin(roll) + d_yaw * np.cos(roll) * np.cos(pitch),
        ]
    )


@entry_point
def _along(
    P: np.ndarray, K: np.ndarray, positions: np.ndarray, rates: np.ndarray, base: np.ndarray, out: np.ndarray
) -> None:
    for k in range(positions.shape[0]):
        b = base[min(k, base.shape[0] - 1)]
        state = ((b[0], b[1], b[2]), (b[3], b[4], b[5]), (b[6], b[7], b[8]))
        mass, bias, outer, inner, _ = equations_of_motion(
            P, K, (positions[k, 0], positions[k, 1]), (rates[k, 0], rates[k, 1]), state
        )
        out[k, 0], out[k, 1] = bias
        out[k, 2], out[k, 3], out[k, 4] = mass
        out[k, 5], out[k, 6] = outer[2], inner[1]
