"""Configuration of one axis: loops, prefilter, feedforward, limits."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from pydantic import Field, model_validator

from firmware_protocol.documents import Strict
from firmware_protocol.mail import IDENTITY_UNIT_TORQUE_EXPONENT_OUTER_HIGH, SET_POINT_TORQUE_OUTER_HIGH
from firmware_protocol.schema import POSITION_STEP_RAD, TORQUE_STEP_NM

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

    kp_per_s: NotNegative
    ki_per_s2: NotNegative = 0.0
    rate_limit_rad_s: Positive
    anti_windup: AntiWindupChoice = AntiWindupChoice.CLAMPING
    #: of back-calculation
    tracking_time_s: Positive = 0.1


class RateLoop(Strict):
    """Gyro error to controller units, kp + ki/s; a unit is `torque_per_unit_nm`. With 1 N m the gains are N m s/rad and
    N m/rad.
    """

    kp_s_per_rad: NotNegative
    ki_per_rad: NotNegative = 0.0
    torque_per_unit_nm: Positive = 1.0
    anti_windup: AntiWindupChoice = AntiWindupChoice.CLAMPING
    tracking_time_s: Positive = 0.02


class Prefilter(Strict):
    """First-order filter of the position reference, num / (den[0] s + den[1]), as table 5.11 of the thesis writes
    it.
    """

    num: Positive
    den: tuple[Positive, Positive]


class Feedforward(Strict):
    """What is given to the loops in advance; compensation of friction and gravity is off at zero."""

    #: share of the position reference's slope that goes to the rate loop
    reference_rate: Annotated[float, Field(ge=0.0, le=1.0)] = 1.0
    #: add the base rate (from the INS) to joint rate references, because a gyro reads the inertial rate
    base_rate: bool = True
    coulomb_nm: NotNegative = 0.0
    viscous_nm_s_per_rad: NotNegative = 0.0
    sign_width_rad_s: Positive = 0.005
    #: mass times centre of gravity of this axis' body, in its axes
    moment_kg_m: tuple[float, float, float] = (0.0, 0.0, 0.0)


class Limits(Strict):
    """What the supervisor holds this axis to."""

    torque_nm: Annotated[float, Field(gt=0.0, le=WIRE_TORQUE_NM)]
    #: soft travel limits of the joint; none without a number
    position_low_rad: float | None = None
    position_high_rad: float | None = None
    #: how far the cable may be wound either way of zero
    cable_wrap_turns: Annotated[float, Field(gt=0.0, lt=WIRE_TURNS)] | None = None
    #: beyond a soft limit by this much is a fault
    travel_margin_rad: NotNegative = 0.05
    rate_rad_s: Positive
    following_position_rad: Positive | None = None
    following_rate_rad_s: Positive | None = None
    gyro_encoder_rad_s: Positive | None = None
    #: gyro against encoder over the supervisor's `gyro_encoder_window_s`
    gyro_encoder_rad: Positive | None = None
    #: samples in a row after which a gyro that has noise is stuck when it does not change
    stuck_gyro_ticks: Annotated[int, Field(ge=2)] | None = None
    braking_rad_s2: Positive
    rest_rate_rad_s: Positive = 0.02
    winding_degc: float = 110.0

    @model_validator(mode="after")
    def _in_order(self) -> Limits:
        low, high = self.position_low_rad, self.position_high_rad
        if low is not None and high is not None and low >= high:
            raise ValueError("position_low_rad is not below position_high_rad")
        return self


class Expectation(Strict):
    """How the axis answers torque, for the guard that trips when it does not: it need be right to a half only."""

    inertia_kg_m2: Positive
    #: most torque that is neither the motor's nor the weight's of `moment_kg_m`: friction, coupling of the axes, a
    #: cable
    disturbance_nm: Positive
    #: mass times centre of gravity of this axis' body, in its axes: its weight on a base that tilts and shifts is
    #: expected
    moment_kg_m: tuple[float, float, float] = (0.0, 0.0, 0.0)


class AxisSettings(Strict):
    """One axis."""

    #: the axis that carries this one; none for the one that turns on the base
    parent: str | None = None

    position_loop: PositionLoop
    rate_loop: RateLoop
    #: none unless given
    prefilter: Prefilter | None = None
    feedforward: Feedforward = Feedforward()
    limits: Limits
    #: none: no guard on motion against torque
    expectation: Expectation | None = None
