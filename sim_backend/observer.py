"""A model as an observer of an antenna: it gets the antenna's torques, is led along the measured positions, and tells
the torque that it lacks for that.

A Luenberger observer with the missing acceleration as a constant state (a triple pole), the plant itself as its model:
Ellis, "Observers in control systems", 2002, chapter 4; the missing torque is the mass matrix times that acceleration.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled, entry_point
from sim_backend.base_motion import base_state
from sim_backend.layout import (
    AXES,
    AXIS_BLOCK,
    AXIS_SIZE,
    BASE_COLUMNS,
    BASE_KIND,
    BASE_ROW_S,
    BASE_ROWS,
    BASE_TABLE,
    ENCODER_NOISE,
    ENCODER_STEP,
    GYRO_NOISE,
    GYRO_STEP,
    HELD,
    P_SIZE,
    POSITION,
    RATE,
    STEP_S,
    STEPS,
    STEPS_PER_TICK,
    TORQUE_NOISE,
    BaseKind,
)
from sim_backend.model import AntennaModel, plant_arrays
from sim_backend.rigid_body import equations_of_motion
from sim_backend.step import observed_tick, read_encoder, read_gyro, true_rates

#: columns of what `observe` is given: ticks of the antenna since the row before, torque that acted over the last of
#: them and over those before it (N m), encoder (rad), gyro (rad/s), whether it was measured, whether the axes are free
#: to move under torque
ELAPSED, TORQUE, TORQUE_BEFORE, ENCODER, GYRO, MEASURED, FREE = 0, 1, 3, 5, 7, 9, 10
INPUTS = 11
#: columns of what it tells, two each: missing torque (N m), gyro less what the model's gyro would read (rad/s)
MISSING, GYRO_ERROR = 0, 2
OUTPUTS = 4
#: an antenna that was not heard for longer than this many of its ticks is taken up anew
MOST_ELAPSED = 200


@entry_point
def observe(
    P: np.ndarray,
    K: np.ndarray,
    X: np.ndarray,
    lacking: np.ndarray,
    rows: np.ndarray,
    bandwidth: float,
    out: np.ndarray,
) -> None:
    """Take `rows` (n, INPUTS) in, fill `out` (n, OUTPUTS). `lacking` (2,) is the state beside X: missing acceleration,
    rad/s^2; `bandwidth` is that of the triple pole, rad/s.
    """
    for k in range(rows.shape[0]):
        _observe_row(P, K, X, lacking, rows[k], bandwidth, out[k])


@compiled
def _observe_row(
    P: np.ndarray, K: np.ndarray, X: np.ndarray, lacking: np.ndarray, row: np.ndarray, bandwidth: float, out: np.ndarray
) -> None:
    elapsed = int(row[ELAPSED])
    if row[FREE] == 0.0 or elapsed > MOST_ELAPSED:
        if row[MEASURED] != 0.0:
            for axis in range(K[AXES]):
                X[POSITION + axis], X[RATE + axis], lacking[axis] = row[ENCODER + axis], 0.0, 0.0
        for column in range(OUTPUTS):
            out[column] = 0.0
        return
    tick_s = P[STEP_S] * K[STEPS_PER_TICK]
    for n in range(elapsed):
        at = TORQUE if n == elapsed - 1 else TORQUE_BEFORE
        observed_tick(P, K, X, (row[at], row[at + 1]))
        for axis in range(K[AXES]):
            X[RATE + axis] += tick_s * lacking[axis]
    true_rates(P, K, X)
    tick = int(X[STEPS]) // K[STEPS_PER_TICK]
    for axis in range(K[AXES]):
        if row[MEASURED] != 0.0 and elapsed > 0:
            # an antenna that was silent for a while is led back no faster than one that was not
            error = row[ENCODER + axis] - read_encoder(P, K, X, axis, tick)
            # bristles are not led: shifted too they would make the observer stick and slip where a joint slides slowly
            X[POSITION + axis] += 3.0 * bandwidth * tick_s * error
            X[RATE + axis] += 3.0 * bandwidth**2 * tick_s * error
            lacking[axis] += bandwidth**3 * tick_s * error
            out[GYRO_ERROR + axis] = row[GYRO + axis] - read_gyro(P, K, X, axis, tick)
    base = base_state(P, K, X[STEPS] * P[STEP_S])
    mass, _, _, _, _ = equations_of_motion(P, K, (X[POSITION], X[POSITION + 1]), (X[RATE], X[RATE + 1]), base)
    out[MISSING] = mass[0] * lacking[0] + mass[1] * lacking[1]
    out[MISSING + 1] = mass[1] * lacking[0] + mass[2] * lacking[1]


class ModelObserver:
    """A model led along what an antenna measures. The base is as `base_is` was last told, level and still before."""

    def __init__(self, model: AntennaModel, rate_hz: float, bandwidth_rad_s: float) -> None:
        """BadInputError where a tick is no whole number of the model's plant steps."""
        arrays = plant_arrays(model, rate_hz)
        self.axes = len(model.axes)
        self._P, self._K, self._X = np.concatenate([arrays.P[:P_SIZE], np.zeros(2 * BASE_COLUMNS)]), arrays.K, arrays.X
        self._lacking, self._bandwidth = np.zeros(2), bandwidth_rad_s
        # the model's own sensors are read without noise and steps
        for axis in range(2):
            block = AXIS_BLOCK + axis * AXIS_SIZE
            for slot in (ENCODER_NOISE, ENCODER_STEP, GYRO_NOISE, GYRO_STEP, TORQUE_NOISE):
                self._P[block + slot] = 0.0
        self._X[HELD : HELD + 2] = 0.0
        self._K[BASE_KIND], self._K[BASE_ROWS], self._K[BASE_TABLE] = int(BaseKind.RECORDED), 2, P_SIZE
        self._P[BASE_ROW_S] = 1.0

    def base_is(self, row: np.ndarray) -> None:
        """Base motion from now on, (12,): roll, pitch, yaw (rad), p, q, r (rad/s), p', q', r' (rad/s^2), then the
        acceleration of the pivot (m/s^2), in base axes.
        """
        self._P[P_SIZE : P_SIZE + BASE_COLUMNS] = self._P[P_SIZE + BASE_COLUMNS :] = row

    def observe(self, rows: np.ndarray) -> np.ndarray:
        """Missing torques (N m) and gyro errors (rad/s), (n, OUTPUTS), for rows (n, INPUTS)."""
        out = np.zeros((len(rows), OUTPUTS))
        observe(self._P, self._K, self._X, self._lacking, np.ascontiguousarray(rows), self._bandwidth, out)
        return out
