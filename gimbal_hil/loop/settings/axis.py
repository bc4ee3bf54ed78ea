"""Configuration of one axis: loops, prefilter, feedforward, limits."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Self

from pydantic import Field, model_validator

from firmware_protocol.documents import Strict
from firmware_protocol.mail import IDENTITY_UNIT_TORQUE_EXPONENT_OUTER_HIGH, SET_POINT_TORQUE_OUTER_HIGH
from firmware_protocol.schema import POSITION_STEP_RAD, TORQUE_STEP_NM
from gimbal_hil.loop.settings.learning import FrictionLevels, LearnedTorque

#: what the wire can carry either way, the torque of an antenna whose identity tells the largest exponent
WIRE_TORQUE_NM = SET_POINT_TORQUE_OUTER_HIGH * TORQUE_STEP_NM * 2.0**IDENTITY_UNIT_TORQUE_EXPONENT_OUTER_HIGH
WIRE_TURNS = 2.0**25 * POSITION_STEP_RAD / 6.283185307179586

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]


class AntiWindupChoice(StrEnum):
    """What keeps an integrator from growing while its output is limited."""

    NONE = "none"
    CLAMPING = "clamping"
    BACK_CALCULATION = "back_calculation"


class PositionLoop(Strict):
    """Encoder error to joint rate reference: kp + ki/s."""

    kp_per_s: NotNegative = Field(description="proportional gain, 1/s")
    ki_per_s2: NotNegative = Field(default=0.0, description="integral gain, 1/s^2")
    rate_limit_rad_s: Positive = Field(description="largest rate that the loop asks for")
    anti_windup: AntiWindupChoice = Field(
        default=AntiWindupChoice.CLAMPING, description="what the integrator does while the output is limited"
    )
    tracking_time_s: Positive = Field(default=0.1, description="time constant of `back_calculation`")


class RateLoop(Strict):
    """Gyro error to controller units, kp + ki/s; a unit is `torque_per_unit_nm`. With 1 N m the gains are N m s/rad and
    N m/rad.
    """

    kp_s_per_rad: NotNegative = Field(
        description="proportional gain, controller units per rad/s: N m s/rad where a unit is 1 N m"
    )
    ki_per_rad: NotNegative = Field(
        default=0.0, description="integral gain, controller units per rad: N m/rad where a unit is 1 N m"
    )
    torque_per_unit_nm: Positive = Field(default=1.0, description="torque of one controller unit")
    anti_windup: AntiWindupChoice = Field(
        default=AntiWindupChoice.CLAMPING, description="what the integrator does while the output is limited"
    )
    tracking_time_s: Positive = Field(default=0.02, description="time constant of `back_calculation`")


class Prefilter(Strict):
    """First-order filter of the position reference, num / (den[0] s + den[1]), as table 5.11 of the thesis writes
    it.
    """

    num: Positive = Field(description="numerator")
    den: tuple[Positive, Positive] = Field(description="denominator, s term first")
    rate_rad_s: Positive | None = Field(
        default=None,
        description="its output moves no faster, so that steps of any size can be followed; no limit unless given",
    )
    acceleration_rad_s2: Positive | None = Field(
        default=None, description="nor does it speed up or brake harder; goes with `rate_rad_s`"
    )

    @model_validator(mode="after")
    def _both_limits(self) -> Self:
        if (self.rate_rad_s is None) != (self.acceleration_rad_s2 is None):
            raise ValueError("has one of rate_rad_s and acceleration_rad_s2; expected both or neither")
        return self


class Feedforward(Strict):
    """Feed-forward of the loops; compensation of friction and gravity is off at zero."""

    reference_rate: Annotated[float, Field(ge=0.0, le=1.0)] = Field(
        default=1.0, description="share of the position reference's slope that goes to the rate loop"
    )
    base_rate: bool = Field(
        default=True,
        description=(
            "add the base rate (from the INS) to joint rate references, because a gyro reads the inertial rate; "
            "without base messages the base counts as fixed"
        ),
    )
    coulomb_nm: NotNegative = Field(
        default=0.0, description="Coulomb friction compensated by the sign of the rate reference"
    )
    viscous_nm_s_per_rad: NotNegative = Field(default=0.0, description="viscous friction compensated, N m s/rad")
    sign_width_rad_s: Positive = Field(default=0.005, description="rate over which that sign goes from -1 to 1")
    moment_kg_m: tuple[float, float, float] = Field(
        default=(0.0, 0.0, 0.0),
        description="mass times centre of gravity of this axis' body, in its axes: its weight is compensated",
    )


class JointObserver(Strict):
    """Kalman observer of joint position, rate and disturbance, from encoder, gyro, base rate and the torque sent; the
    loops work on its estimates, and the disturbance takes the integrators' place. Noises, gyro lag and delay are those
    of `model_control.model`.
    """

    bandwidth_rad_s: Positive = Field(description="how fast a disturbance is estimated")
    offset_walk_rad_s: Positive = Field(
        default=0.003,
        description="random walk of the gyro against joint and base rate, rad/s: its standard deviation after a second",
    )
    gusts_above_rad_s: Positive | None = Field(
        default=None,
        description=(
            "disturbances above this frequency are taken for gusts, which come and go, below it for lasting ones; "
            "without a number all last"
        ),
    )
    position_kp_per_s: Positive | None = Field(
        default=None, description="`position_loop.kp_per_s` while the observer closes the loops; the same unless given"
    )
    rate_kp_s_per_rad: Positive | None = Field(default=None, description="`rate_loop.kp_s_per_rad` likewise")
    delay_ticks: Annotated[int, Field(ge=0, le=8)] | None = Field(
        default=None, description="ticks from a torque to its effect, in place of the model's"
    )


class Limits(Strict):
    """What the supervisor holds this axis to."""

    torque_nm: Annotated[float, Field(gt=0.0, le=WIRE_TORQUE_NM)] = Field(
        description="largest torque that the host asks for"
    )
    position_low_rad: float | None = Field(
        default=None, description="lower soft travel limit of the joint; none without a number"
    )
    position_high_rad: float | None = Field(default=None, description="upper soft travel limit")
    cable_wrap_turns: Annotated[float, Field(gt=0.0, lt=WIRE_TURNS)] | None = Field(
        default=None, description="how far the cable may be wound either way of zero"
    )
    travel_margin_rad: NotNegative = Field(default=0.05, description="beyond a soft limit by this much is a fault")
    rate_rad_s: Positive = Field(
        description="joint rate beyond which `OVERSPEED` trips; the loops ask for 80 % of it at most"
    )
    following_position_rad: Positive | None = Field(default=None, description="position error for `FOLLOWING_ERROR`")
    following_rate_rad_s: Positive | None = Field(default=None, description="rate error for `FOLLOWING_ERROR`")
    gyro_encoder_rad_s: Positive | None = Field(
        default=None, description="difference of both rates for `GYRO_ENCODER_DISAGREE`"
    )
    gyro_encoder_rad: Positive | None = Field(
        default=None, description="difference of both angles over `supervisor.gyro_encoder_window_s` for `SENSOR_DRIFT`"
    )
    stuck_gyro_ticks: Annotated[int, Field(ge=2)] | None = Field(
        default=None, description="samples in a row after which a gyro that had noise and does not change is stuck"
    )
    braking_rad_s2: Positive = Field(description="deceleration with which the axis is brought to rest")
    rest_rate_rad_s: Positive = Field(default=0.02, description="slower than this counts as at rest")
    winding_degc: float = Field(default=110.0, description="winding temperature for `TEMPERATURE`")

    @model_validator(mode="after")
    def _in_order(self) -> Limits:
        low, high = self.position_low_rad, self.position_high_rad
        if low is not None and high is not None and low >= high:
            raise ValueError("position_low_rad is not below position_high_rad")
        return self


class Expectation(Strict):
    """How the axis answers torque, for the guard that trips when it does not: it need be right to a half only."""

    inertia_kg_m2: Positive = Field(description="inertia about the axis")
    inertia_within: Annotated[float, Field(ge=1.0, le=3.0)] = Field(
        default=3.0,
        description=(
            "factor within which it is known; from 1.15 down the first test fails where gear or encoder counts are "
            "half or twice what they should be"
        ),
    )
    disturbance_nm: Positive = Field(
        description="most torque that is neither the motor's nor the weight's: friction, coupling of the axes, a cable"
    )
    moment_kg_m: tuple[float, float, float] = Field(
        default=(0.0, 0.0, 0.0),
        description=(
            "mass times centre of gravity of this axis' body, in its axes: its weight on a base that tilts and shifts"
            " is expected"
        ),
    )


class AdjustableKey(StrEnum):
    """Numbers of an axis that may be made adjustable; a limit can only be made tighter than the file has it."""

    POSITION_KP = "position_loop.kp_per_s"
    POSITION_KI = "position_loop.ki_per_s2"
    POSITION_RATE = "position_loop.rate_limit_rad_s"
    RATE_KP = "rate_loop.kp_s_per_rad"
    RATE_KI = "rate_loop.ki_per_rad"
    REFERENCE_RATE = "feedforward.reference_rate"
    COULOMB = "feedforward.coulomb_nm"
    VISCOUS = "feedforward.viscous_nm_s_per_rad"
    LEARNED_SHARE = "learned.share"
    TORQUE = "limits.torque_nm"
    RATE = "limits.rate_rad_s"
    TRAVEL_LOW = "limits.position_low_rad"
    TRAVEL_HIGH = "limits.position_high_rad"
    FOLLOWING_POSITION = "limits.following_position_rad"
    FOLLOWING_RATE = "limits.following_rate_rad_s"


class AxisSettings(Strict):
    """One axis."""

    parent: str | None = Field(
        default=None, description="the axis that carries this one; none for the one that turns on the base"
    )

    position_loop: PositionLoop = Field(description="encoder loop, over the rate loop")
    rate_loop: RateLoop = Field(description="gyro loop")
    prefilter: Prefilter | None = Field(default=None, description="of the position reference; none unless given")
    feedforward: Feedforward = Field(default=Feedforward(), description="feed-forward of the loops")
    observer: JointObserver | None = Field(
        default=None, description="closes the loops with estimates instead of raw sensors; needs `model_control`"
    )
    friction_levels: FrictionLevels | None = Field(
        default=None, description="estimates friction levels from the torque that the loops add; needs `model_control`"
    )
    learned: LearnedTorque | None = Field(
        default=None, description="torque over position and direction, learned in service; needs `model_control`"
    )
    limits: Limits = Field(description="limits of the supervisor's guards")
    expectation: Expectation | None = Field(
        default=None,
        description="how it responds to torque; without it no guard on motion against torque and no first test",
    )
    adjustable: dict[AdjustableKey, tuple[float, float]] = Field(
        default={},
        description=(
            "gains and limits that may be changed while the daemon runs, each with least and largest value, as in "
            "`rate_loop.kp_s_per_rad: [30, 90]`; a limit can only be made tighter than this file has it"
        ),
    )

    @model_validator(mode="after")
    def _bounds_are_bounds(self) -> Self:
        for key, (low, high) in self.adjustable.items():
            if number_at(self, key.value) is None:
                place = key.value.partition(".")[0]
                raise ValueError(f"adjustable.{key.value}: the number itself is not given; expected it in {place}")
            if not low <= high:
                raise ValueError(f"adjustable.{key.value}: {low:g} to {high:g}; expected least and largest value")
            if low < 0.0 and key not in (AdjustableKey.TRAVEL_LOW, AdjustableKey.TRAVEL_HIGH):
                raise ValueError(f"adjustable.{key.value}: {low:g} is negative; expected 0 or more")
        return self

    def bounds(self, key: AdjustableKey) -> tuple[float, float]:
        """Least and largest value that a number may be given: what the file allows, always with the configured number,
        and for a limit nothing looser than that.
        """
        low, high = self.adjustable[key]
        configured = number_at(self, key.value)
        assert configured is not None, "the section was validated"
        low, high = min(low, configured), max(high, configured)
        if key is AdjustableKey.TRAVEL_LOW:
            return configured, high
        return low, configured if key.value.startswith("limits.") else high

    def with_paths_from(self, folder: Path) -> AxisSettings:
        """The same with the learned table's file found from `folder`."""
        if self.learned is None or self.learned.table is None:
            return self
        table = str((folder / self.learned.table).resolve())
        return self.model_copy(update={"learned": self.learned.model_copy(update={"table": table})})

    def with_entries(self, name: str) -> AxisSettings:
        """The same with the learned table itself in it; BadInputError where its file has none for this axis."""
        if self.learned is None or self.learned.entries is not None:
            return self
        entries = self.learned.entries_of(name)
        return self.model_copy(update={"learned": self.learned.model_copy(update={"entries": entries})})


def number_at(axis: AxisSettings, key: str) -> float | None:
    """The number that a dotted key names; None where the axis has none."""
    section, _, name = key.partition(".")
    value = getattr(getattr(axis, section, None), name, None)
    return None if value is None else float(value)
