"""Do units and signs of a log fit the model? Its torque against its own acceleration, its gyro against its own encoder.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from firmware_protocol.errors import BadInputError
from gimbal_hil.signals import SignalsTable
from sim_backend.model import AntennaModel

#: both sides are smoothed over this long, s: flexible parts, delays and lags act faster
_SMOOTHING_S = 0.05
#: a slope counts when what it explains is at least this share of what is left of the other signal without it ...
_EXPLAINED = 0.5
#: ... and when at least this share of the regressor is not already said by position, rate and direction
_OWN_SHARE = 0.05
#: no rig differs from its model by such a factor; degrees are 57, millinewton metres 1,000
_MOST_INERTIA, _MOST_RATE = 20.0, 5.0
#: share of the model's Coulomb friction that its inertia must have taken, rms, for torque to speak of an inertia
_FAIR_SHARE = 0.2
#: rows slower than this share of the top speed are left out: there friction holds
_MOVING = 0.1


@dataclass(frozen=True)
class Slope:
    """Slope of one signal on another beside nuisances, and the share (0 to 1) of what is left that it explains."""

    value: float
    explained: float


def check_units(model: AntennaModel, table: SignalsTable, axis: str, where: str) -> None:
    """Raise BadInputError where torque, position or rate of an axis cannot be in SI units with the model's sign."""
    position = table.position(axis)
    width = max(2.0, _SMOOTHING_S / table.period_s)
    if len(position) < 20.0 * width or float(np.ptp(position)) == 0.0:
        return
    rate = np.asarray(gaussian_filter1d(position, width, order=1)) / table.period_s
    moving = np.abs(rate) > _MOVING * float(np.abs(rate).max())
    gyro = table.signal(axis, "rate")
    if gyro is not None and np.any(gyro != 0.0):
        _check_gyro(slope(np.asarray(gaussian_filter1d(gyro, width)), rate, np.ones((len(rate), 1))), axis, where)
    acceleration = np.asarray(gaussian_filter1d(position, width, order=2)) / table.period_s**2
    torque = np.asarray(gaussian_filter1d(table.torque(axis), width))
    inertia, coulomb = model.number(axis, model.own_inertia_path(axis)), model.number(axis, "friction.coulomb")
    if inertia * float(np.sqrt(np.mean(acceleration[moving] ** 2))) < _FAIR_SHARE * coulomb:
        # a bristle is a spring: where friction is all that torque works against, it goes with position and against
        # acceleration
        return
    place = (position - position.mean()) / float(np.ptp(position))
    beside = np.column_stack([np.ones_like(rate), rate, np.sign(rate), place, place**2, place**3])
    _check_inertia(slope(torque[moving], acceleration[moving], beside[moving]), inertia, axis, where)


def slope(of: NDArray[np.float64], on: NDArray[np.float64], beside: NDArray[np.float64]) -> Slope | None:
    """Least-squares slope of `of` (n,) on `on` (n,) with the columns of `beside` (n, k) taken out of both; None where
    nothing is left.
    """
    if len(on) < 10 * beside.shape[1]:
        return None
    left = on - beside @ np.linalg.lstsq(beside, on, rcond=None)[0]
    rest = of - beside @ np.linalg.lstsq(beside, of, rcond=None)[0]
    power, whole = float(left @ left), float(np.sum((on - on.mean()) ** 2))
    if power <= _OWN_SHARE * whole or float(rest @ rest) == 0.0:
        return None
    value = float(left @ rest) / power
    return Slope(value, value**2 * power / float(rest @ rest))


def _check_gyro(found: Slope | None, axis: str, where: str) -> None:
    if found is None or found.explained < _EXPLAINED or 1.0 / _MOST_RATE < found.value < _MOST_RATE:
        return
    raise BadInputError(
        f"{where}: {axis}.rate",
        f"is {found.value:.3g} times the rate at which {axis}.position changes",
        "rad and rad/s, of the same sign",
    )


def _check_inertia(found: Slope | None, inertia: float, axis: str, where: str) -> None:
    if found is None or found.explained < _EXPLAINED or inertia <= 0.0:
        return
    if found.value < 0.0:
        raise BadInputError(
            f"{where}: {axis}.torque",
            f"pushes against the acceleration of {axis}.position",
            "torque that is positive towards growing position",
        )
    if not inertia / _MOST_INERTIA < found.value < inertia * _MOST_INERTIA:
        raise BadInputError(
            f"{where}: {axis}.torque and {axis}.position",
            f"speak of an inertia of {found.value:.3g} where the model has {inertia:.3g}",
            "SI units (rad and N m, or m and N)",
        )  # fmt: skip
