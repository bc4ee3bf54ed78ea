"""Chapter 4: friction over velocity, the loop around zero speed, and what a secant makes of the bristle stiffness."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from firmware_protocol.compiling import entry_point
from gimbal_hil.proof.thesis.printed import PRESLIDING, SLIDING_HIGH_RAD_S, SLIDING_LOW_RAD_S, SLIDING_SPEEDS
from sim_backend.friction import lugre_step, stribeck_level
from sim_backend.model import AntennaModel

_STEP_S = 1e-4
#: one sine period of velocity: amplitude (rad/s) wide enough for bump and viscous rise, and the periods shown (s)
LOOP_AMPLITUDE_RAD_S = 0.05
LOOP_PERIODS_S = (1.0, 5.0, 25.0)
#: shares of the break-away torque at which a secant is taken
SECANT_SHARES = (0.1, 0.5, 0.9, 0.98)


@dataclass(frozen=True)
class CurveFriction:
    """The seven numbers of a joint's friction, SI."""

    breakaway: float
    coulomb: float
    stribeck_velocity: float
    sigma0: float
    sigma1: float
    viscous: float
    shape: float

    def steady(self, rate_rad_s: np.ndarray) -> np.ndarray:
        """Torque at constant rates, N m: the corrected eq. 4.3."""
        bump = (self.breakaway - self.coulomb) * np.exp(-((np.abs(rate_rad_s) / self.stribeck_velocity) ** self.shape))
        return np.asarray(np.sign(rate_rad_s) * (self.coulomb + bump) + self.viscous * rate_rad_s)

    def steady_as_printed(self, rate_rad_s: np.ndarray) -> np.ndarray:
        """Eq. 4.3 with the exponent as printed, +|v|^delta / v_s: it grows without bound."""
        bump = (self.breakaway - self.coulomb) * np.exp(np.abs(rate_rad_s) ** self.shape / self.stribeck_velocity)
        return np.asarray(np.sign(rate_rad_s) * (self.coulomb + bump) + self.viscous * rate_rad_s)


@dataclass(frozen=True)
class HysteresisLoop:
    """Friction along one sine period of velocity, after a period to forget the start."""

    period_s: float
    rate_rad_s: np.ndarray
    torque_nm: np.ndarray


@dataclass(frozen=True)
class FrictionCurves:
    """Chapter 4 for one axis."""

    axis: str
    friction: CurveFriction
    rate_rad_s: np.ndarray
    steady_nm: np.ndarray
    minimum_rad_s: float
    #: eq. 4.3 as printed, at the fastest speed of the sliding experiment, N m
    printed_at_fastest_nm: float
    loops: tuple[HysteresisLoop, ...]
    #: (share of break-away, secant stiffness over sigma0)
    secants: tuple[tuple[float, float], ...]
    #: dT/dz of table 4.4, and what the angle of table 4.3 gives, N m/rad
    stiffness_of_table_4_4: float
    stiffness_of_table_4_3: float
    #: damping ratio that sigma1 stands for
    damping_ratio: float


def friction_of(model: AntennaModel, axis: str) -> CurveFriction:
    """Friction of a model's axis."""
    names = ("breakaway", "coulomb", "stribeck_velocity", "sigma0", "sigma1", "viscous", "shape")
    return CurveFriction(*(model.number(axis, f"friction.{name}") for name in names))


def sliding_speeds() -> np.ndarray:
    """The 45 speeds of the sliding experiment (rad/s); the thesis gives range and number, and says that slow ones are
    denser.
    """
    return np.geomspace(SLIDING_LOW_RAD_S, SLIDING_HIGH_RAD_S, SLIDING_SPEEDS)


def friction_curves(model: AntennaModel, axis: str) -> FrictionCurves:
    """Everything of chapter 4 that follows from the tabulated friction of one axis."""
    friction = friction_of(model, axis)
    fine = np.geomspace(1e-4, SLIDING_HIGH_RAD_S, 4000)
    angle_deg, torque, deflection = PRESLIDING[axis]
    inertia = model.number(axis, model.own_inertia_path(axis))
    speeds = sliding_speeds()
    return FrictionCurves(
        axis,
        friction,
        speeds,
        friction.steady(speeds),
        float(fine[np.argmin(friction.steady(fine))]),
        float(friction.steady_as_printed(np.array([SLIDING_HIGH_RAD_S]))[0]),
        tuple(friction_loop(friction, LOOP_AMPLITUDE_RAD_S, period) for period in LOOP_PERIODS_S),
        tuple((share, -share / math.log(1.0 - share)) for share in SECANT_SHARES),
        torque / deflection,
        torque / math.radians(angle_deg),
        (friction.sigma1 + friction.viscous) / (2.0 * math.sqrt(friction.sigma0 * inertia)),
    )


def friction_loop(friction: CurveFriction, amplitude_rad_s: float, period_s: float) -> HysteresisLoop:
    """Friction along a sine of velocity: one period, after one to forget the start."""
    samples = round(period_s / _STEP_S)
    rate = amplitude_rad_s * np.sin(2.0 * math.pi * (np.arange(2 * samples) + 0.5) / samples)
    torque = friction_along(friction, rate, _STEP_S)
    return HysteresisLoop(period_s, rate[samples:], torque[samples:])


def friction_along(friction: CurveFriction, rate_rad_s: np.ndarray, step_s: float) -> np.ndarray:
    """Torque (n,) that opposes a motion given by its rates (n,), each held for a step; the bristles start at rest."""
    torque = np.zeros(len(rate_rad_s))
    f = friction
    numbers = np.array([f.breakaway, f.coulomb, f.stribeck_velocity, f.sigma0, f.sigma1, f.viscous, f.shape])
    _along(numbers, np.ascontiguousarray(rate_rad_s), step_s, torque)
    return torque


@entry_point
def _along(numbers: np.ndarray, rate: np.ndarray, step: float, torque: np.ndarray) -> None:
    z = 0.0
    for k in range(rate.shape[0]):
        level = stribeck_level(abs(rate[k]), numbers[0], numbers[1], numbers[2], numbers[6])
        z, torque[k] = lugre_step(z, rate[k], step, level, numbers[3], numbers[4], numbers[5])
