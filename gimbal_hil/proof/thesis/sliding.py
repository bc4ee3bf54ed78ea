"""The sliding experiment of section 4.3.1 on the simulated antenna, at any temperature.

Each speed is driven through the same window of positions in both directions; half the difference of the two mean
torques is friction, half their sum is gravity on the unbalance, which the thesis' one-directional runs cannot tell
apart.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gimbal_hil.loop.control import Mode
from gimbal_hil.proof.thesis.closed_loop import AxisLoop, Gains, run_closed_loop
from gimbal_hil.proof.thesis.friction_curves import sliding_speeds
from gimbal_hil.proof.thesis.inferred import LEVEL, ideal_sensors
from gimbal_hil.proof.thesis.printed import RATE_GAINS
from sim_backend.model import AntennaModel, shipped_model

TEMPERATURES_DEGC = (-40.0, -15.0, 20.0, 55.0, 85.0)
_RATE_HZ = 1000.0
_AVERAGE_S, _LEAST_SETTLING_S = 0.5, 1.0
#: bristles turned over this many times their break-away deflection have forgotten where they came from
_DEFLECTIONS = 12.0


@dataclass(frozen=True)
class SlidingSweep:
    """Friction over speed as a sliding experiment sees it."""

    axis: str
    temperature_degc: float
    rate_rad_s: np.ndarray
    friction_nm: np.ndarray
    #: mean of the two directions: what is no friction
    offset_nm: np.ndarray
    simulated_s: float


def warm_antenna(temperature_degc: float) -> AntennaModel:
    """The shipped antenna whose friction depends on temperature, at a temperature, with ideal sensors."""
    model = ideal_sensors(shipped_model("thesis-temperature"))
    for axis in model.axes:
        model = model.with_number(axis, "thermal.ambient", temperature_degc)
    return model


def sliding_sweep(
    model: AntennaModel, axis: str, temperature_degc: float = 20.0, speeds: np.ndarray | None = None
) -> SlidingSweep:
    """Drive an axis at each speed (rad/s) in both directions; the other axis holds its rate at zero."""
    rates = sliding_speeds() if speeds is None else speeds
    friction, offset, simulated = [], [], 0.0
    for rate in rates:
        means = []
        for direction in (1.0, -1.0):
            mean, duration = _mean_torque(model, axis, direction * float(rate))
            means.append(mean)
            simulated += duration
        friction.append(0.5 * (means[0] - means[1]))
        offset.append(0.5 * (means[0] + means[1]))
    return SlidingSweep(axis, temperature_degc, np.asarray(rates), np.array(friction), np.array(offset), simulated)


def _mean_torque(model: AntennaModel, axis: str, rate: float) -> tuple[float, float]:
    """Mean torque (N m) over a window about position zero, reached at a settled rate, and the simulated time (s)."""
    index = model.axes.index(axis)
    deflection = model.number(axis, "friction.breakaway") / model.number(axis, "friction.sigma0")
    settling = _LEAST_SETTLING_S + _DEFLECTIONS * deflection / abs(rate)
    samples = round((settling + _AVERAGE_S) * _RATE_HZ)
    average = round(_AVERAGE_S * _RATE_HZ)
    started = model.with_number(axis, "start.position", -rate * (settling + 0.5 * _AVERAGE_S))
    reference = np.zeros((samples, 2))
    reference[:, index] = rate
    loops = [
        AxisLoop(
            Mode.RATE,
            Gains(*RATE_GAINS[name]),
            torque_per_unit_nm=LEVEL.drive(name).per_unit_nm,
            torque_limit_nm=math.inf,
        )
        for name in model.axes
    ]
    response = run_closed_loop(started, loops[0], loops[1], reference, _RATE_HZ)
    return float(response.torque_nm[-average:, index].mean()), samples / _RATE_HZ
