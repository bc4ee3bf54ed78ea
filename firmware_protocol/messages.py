"""Every message as a frozen dataclass in physical units.

Emitted from `schema` by `gimbal-hil protocol --emit messages`; do not edit.
"""

from __future__ import annotations

from dataclasses import dataclass

from firmware_protocol.enumerations import (
    BrakeCommand,
    BrakeState,
    DriveRequest,
    DriveState,
    FaultCode,
    LimitFlags,
    StopReaction,
)


@dataclass(frozen=True, slots=True)
class DriveControl:
    """Drive state requests, on change and repeated."""

    #: state wanted, as a CiA 402 command
    request: DriveRequest
    #: a rising edge leaves FAULT
    fault_reset: bool
    #: stop now, whatever the request
    quick_stop: bool
    #: allow torque that leads back from a travel limit
    clear_travel: bool
    #: how a quick stop stops
    stop: StopReaction
    #: holding brake of the outer axis
    brake_outer: BrakeCommand
    #: holding brake of the inner axis
    brake_inner: BrakeCommand
    #: the antenna may say at once who it is
    identify: bool


@dataclass(frozen=True, slots=True)
class SetPoint:
    """Torque of both axes; a fresh one feeds the deadman."""

    #: torque of the outer axis, held for one tick
    torque_outer_nm: float
    #: torque of the inner axis, held for one tick
    torque_inner_nm: float
    #: number of the tick, modulo 1024
    sequence: int
    #: the outer axis may apply torque
    enable_outer: bool
    #: the inner axis may apply torque
    enable_inner: bool


@dataclass(frozen=True, slots=True)
class DeadmanConfig:
    """Deadman, sent at connection."""

    #: ticks without a fresh set-point before the reaction
    window_ticks: int
    #: what the drive does then
    reaction: StopReaction


@dataclass(frozen=True, slots=True)
class FeedbackOuter:
    """Sensors of the outer axis, sampled at this tick."""

    #: joint angle from the encoder, multi-turn
    position_rad: float
    #: inertial rate about the axis from the gyro
    rate_rad_s: float


@dataclass(frozen=True, slots=True)
class FeedbackInner:
    """Sensors of the inner axis, sampled at this tick."""

    #: joint angle from the encoder, multi-turn
    position_rad: float
    #: inertial rate about the axis from the gyro
    rate_rad_s: float


@dataclass(frozen=True, slots=True)
class DriveStatus:
    """State of the drive; closes the feedback set of a tick."""

    #: drive state
    state: DriveState
    #: latched fault
    fault: FaultCode
    #: sequence of the set-point that acted before this sample
    last_sequence: int
    #: ticks left before the deadman reacts
    deadman_margin_ticks: int
    #: limits that act now
    limits: LimitFlags
    #: the device's tick, modulo 4096
    tick: int


@dataclass(frozen=True, slots=True)
class MotorStatusOuter:
    """Motor of the outer axis."""

    #: torque measured at the actuator, from motor current
    torque_nm: float
    #: winding temperature
    temperature_degc: float
    #: supply voltage
    supply_v: float
    #: holding brake
    brake: BrakeState
    #: the drive has shorted this winding
    shorted: bool


@dataclass(frozen=True, slots=True)
class MotorStatusInner:
    """Motor of the inner axis."""

    #: torque measured at the actuator, from motor current
    torque_nm: float
    #: winding temperature
    temperature_degc: float
    #: supply voltage
    supply_v: float
    #: holding brake
    brake: BrakeState
    #: the drive has shorted this winding
    shorted: bool


@dataclass(frozen=True, slots=True)
class BaseAttitude:
    """Attitude of the base, R_eb = Rz(yaw) Ry(pitch) Rx(roll); base_heading in the next tick closes the set."""

    #: base roll
    roll_rad: float
    #: base pitch
    pitch_rad: float
    #: lowest bits of the `valid_tick` of the base_heading that belongs to it
    set: int


@dataclass(frozen=True, slots=True)
class BaseRate:
    """Angular rate of the base in base axes."""

    #: base p
    p_rad_s: float
    #: base q
    q_rad_s: float
    #: base r
    r_rad_s: float


@dataclass(frozen=True, slots=True)
class DriveEvent:
    """One transition of the drive state machine."""

    #: state before
    from_state: DriveState
    #: state after
    to_state: DriveState
    #: why
    cause: FaultCode
    #: more on the cause: axis, limit or request
    detail: int
    #: the device's tick, modulo 4096
    tick: int


@dataclass(frozen=True, slots=True)
class BaseHeading:
    """Heading of the base, and when the attitude was true."""

    #: base yaw
    yaw_rad: float
    #: the device's tick at which the attitude was true, modulo 4096
    valid_tick: int
    #: and how far into that tick
    valid_fraction_ticks: float


@dataclass(frozen=True, slots=True)
class BaseAcceleration:
    """Acceleration of the pivot in base axes, of the motion alone: gravity is not in it."""

    #: base ax
    ax_m_s2: float
    #: base ay
    ay_m_s2: float
    #: base az
    az_m_s2: float


@dataclass(frozen=True, slots=True)
class Identity:
    """Who the antenna is; at once when asked. Without it and identity_unit no torque is switched on."""

    #: version of this protocol
    protocol_version: int
    #: CRC-32 of the antenna's name in UTF-8, its lower 31 bits
    name: int
    #: the outer axis has a holding brake
    has_brake_outer: bool
    #: the inner axis has a holding brake
    has_brake_inner: bool


@dataclass(frozen=True, slots=True)
class IdentityUnit:
    """Which antenna of its kind it is, and what a unit of its torques is."""

    #: serial number
    serial_number: int
    #: a torque of the outer axis counts its step times two to this
    torque_exponent_outer: int
    #: a torque of the inner axis counts its step times two to this
    torque_exponent_inner: int


AnyMessage = (
    DriveControl
    | SetPoint
    | DeadmanConfig
    | FeedbackOuter
    | FeedbackInner
    | DriveStatus
    | MotorStatusOuter
    | MotorStatusInner
    | BaseAttitude
    | BaseRate
    | DriveEvent
    | BaseHeading
    | BaseAcceleration
    | Identity
    | IdentityUnit
)
CLASSES: dict[str, type[AnyMessage]] = {
    "drive_control": DriveControl,
    "set_point": SetPoint,
    "deadman_config": DeadmanConfig,
    "feedback_outer": FeedbackOuter,
    "feedback_inner": FeedbackInner,
    "drive_status": DriveStatus,
    "motor_status_outer": MotorStatusOuter,
    "motor_status_inner": MotorStatusInner,
    "base_attitude": BaseAttitude,
    "base_rate": BaseRate,
    "drive_event": DriveEvent,
    "base_heading": BaseHeading,
    "base_acceleration": BaseAcceleration,
    "identity": Identity,
    "identity_unit": IdentityUnit,
}
