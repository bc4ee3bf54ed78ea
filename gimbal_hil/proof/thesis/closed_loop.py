"""The thesis' closed loop, compiled: the product's control law and plant, at the rate of the plant's steps.

Gyro and encoder are ideal and no anti-windup is on, as docs/explanation/reading-the-thesis.md infers; everything else
of the project runs with it on.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from firmware_protocol.compiling import entry_point
from gimbal_hil.loop.control import (
    CONTROL_PARAMETERS,
    CONTROL_STATES,
    POSITION_ANTI_WINDUP,
    POSITION_KI,
    POSITION_KP,
    PREFILTER_CORNER,
    PREFILTER_DECAY,
    PREFILTER_GAIN,
    RATE_ANTI_WINDUP,
    RATE_KI,
    RATE_KP,
    RATE_REFERENCE_LIMIT,
    TORQUE_LIMIT,
    TORQUE_SCALE,
    AntiWindup,
    Mode,
    axis_torque,
)
from sim_backend.layout import FRICTION, STEP_S, STEPS, STEPS_PER_TICK
from sim_backend.model import AntennaModel, plant_arrays
from sim_backend.step import plant_tick, read_encoder, read_gyro, true_rates

LOOP_RATE_HZ = 10_000.0
_NO_LIMIT = 1e12


@dataclass(frozen=True)
class Gains:
    """A PI of the thesis: output `kp e + ki (integral of e)`."""

    kp: float
    ki: float


@dataclass(frozen=True)
class AxisLoop:
    """What one axis runs: its mode, the cascade's gains, the drive's gain per controller unit and its limit (N m)."""

    mode: Mode
    rate: Gains
    position: Gains = Gains(0.0, 0.0)
    torque_per_unit_nm: float = 1.0
    torque_limit_nm: float = _NO_LIMIT
    #: prefilter num / (den[0] s + den[1]) of the position reference; none where it is empty
    prefilter: tuple[float, ...] = field(default=())
    #: what the product has on everywhere and the thesis had not
    anti_windup: bool = False

    def parameters(self, step_s: float) -> np.ndarray:
        """This loop as a block of the control law's parameters, (CONTROL_PARAMETERS,)."""
        block = np.zeros(CONTROL_PARAMETERS)
        block[POSITION_KP], block[POSITION_KI], block[RATE_REFERENCE_LIMIT] = (
            self.position.kp,
            self.position.ki,
            _NO_LIMIT,
        )
        block[RATE_KP], block[RATE_KI] = self.rate.kp, self.rate.ki
        block[TORQUE_SCALE], block[TORQUE_LIMIT] = self.torque_per_unit_nm, self.torque_limit_nm
        if self.anti_windup:
            block[RATE_ANTI_WINDUP] = block[POSITION_ANTI_WINDUP] = AntiWindup.CLAMPING
        if self.prefilter:
            numerator, lag, constant = self.prefilter
            corner = constant / lag
            block[PREFILTER_GAIN], block[PREFILTER_CORNER], block[PREFILTER_DECAY] = (
                numerator / constant,
                corner,
                np.exp(-corner * step_s),
            )
        return block


@dataclass(frozen=True)
class LoopResponse:
    """A closed-loop run, n rows at the loop's rate, two axes: row k is sampled at t_k, its torque acts over [t_k,
    t_k+1).
    """

    time_s: np.ndarray
    position_rad: np.ndarray
    #: inertial rate about the axis, as the gyro reads it
    rate_rad_s: np.ndarray
    torque_nm: np.ndarray
    friction_nm: np.ndarray


@entry_point
def _run(
    P: np.ndarray,
    K: np.ndarray,
    X: np.ndarray,
    H: np.ndarray,
    C: np.ndarray,
    modes: np.ndarray,
    reference: np.ndarray,
    rows: np.ndarray,
) -> None:
    step = P[STEP_S] * K[STEPS_PER_TICK]
    for k in range(reference.shape[0]):
        true_rates(P, K, X)
        tick = int(X[STEPS]) // K[STEPS_PER_TICK]
        for axis in range(2):
            position, rate = read_encoder(P, K, X, axis, tick), read_gyro(P, K, X, axis, tick)
            h, c = axis * CONTROL_STATES, axis * CONTROL_PARAMETERS
            torque = axis_torque(
                modes[axis], reference[k, axis], 0.0, position, rate, 0.0, 0.0, (-1e9, 1e9), step, H, h, C, c
            )
            rows[k, axis], rows[k, 2 + axis], rows[k, 4 + axis] = position, rate, torque
        plant_tick(P, K, X, (rows[k, 4], rows[k, 5]))
        rows[k, 6], rows[k, 7] = X[FRICTION], X[FRICTION + 1]


def run_closed_loop(
    model: AntennaModel, outer: AxisLoop, inner: AxisLoop, reference: np.ndarray, rate_hz: float = LOOP_RATE_HZ
) -> LoopResponse:
    """Run both axes from rest under references (n, 2) in each mode's unit (rad, rad/s), one row a tick."""
    arrays = plant_arrays(model, rate_hz)
    C = np.concatenate([outer.parameters(1.0 / rate_hz), inner.parameters(1.0 / rate_hz)])
    modes = np.array([int(outer.mode), int(inner.mode)], dtype=np.int64)
    rows = np.zeros((len(reference), 8))
    _run(
        arrays.P,
        arrays.K,
        arrays.X,
        np.zeros(2 * CONTROL_STATES),
        C,
        modes,
        np.ascontiguousarray(reference, dtype=np.float64),
        rows,
    )
    time = np.arange(len(reference)) / rate_hz
    return LoopResponse(time, *(rows[:, i : i + 2].copy() for i in range(0, 8, 2)))
