"""Every message as a frozen dataclass in physical units.

Emitted from `schema` by `gimbal-hil protocol --emit messages`; do not edit.
"""

from __future__ import annotations

from dataclasses import dataclass

from firmware_protocol.schema import DeadmanReaction, DriveRequest, DriveState, FaultCode, LimitFlags


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
    reaction: DeadmanReaction


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


@dataclass(frozen=True, slots=True)
class MotorStatusInner:
    """Motor of the inner axis."""

    #: torque measured at the actuator, from motor current
    torque_nm: float
    #: winding temperature
    temperature_degc: float
    #: supply voltage
    supply_v: float


@dataclass(frozen=True, slots=True)
class BaseAttitude:
    """Attitude of the base, R_eb = Rz(yaw) Ry(pitch) Rx(roll)."""

    #: base roll
    roll_rad: float
    #: base pitch
    pitch_rad: float
    #: base yaw
    yaw_rad: float


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
}
