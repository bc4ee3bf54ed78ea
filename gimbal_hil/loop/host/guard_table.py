"""Every guard of host and drive in one place: what trips it, what comes of it, how it is left, and the test that fails
without it.

`docs/reference/guards.md` is made from this table (guard_page.py), and `watch` and the live page tell a stop in its
words; a test holds page and table to each other, and the table to the causes that there are.
"""

from __future__ import annotations

from dataclasses import dataclass

from firmware_protocol.enumerations import FaultCode, StopReaction
from gimbal_hil.loop.host.reactions import stop_for
from gimbal_hil.loop.host.states import HostCause

_OPERATOR, _RETURN = "operator's reset", "by itself when feedback returns; torque stays off"
_HOST, _PLAUSIBLE, _PLACES, _CONNECTING = (
    "tests/host/test_guards.py",
    "tests/host/test_plausibility.py",
    "tests/host/test_places.py",
    "tests/host/test_connecting.py",
)
#: what a stop does, in words
STOPS = {
    StopReaction.COAST: "coasts, then the brake closes",
    StopReaction.BRAKE: "braked without any sensor: winding shorted, brake closes",
    StopReaction.DECELERATE_AND_HOLD: "ramped to rest by the encoder, held, then the brake closes",
    StopReaction.GYRO_STOP: "braked by torque against the gyro's rate; the brake closes at rest",
}


@dataclass(frozen=True)
class HostGuard:
    """A guard of the host; its reaction follows from the cause (`reactions`)."""

    cause: HostCause
    trigger: str
    reset: str
    test: str
    #: what an operator looks at first
    look_at: str
    #: where the host does not go to FAULT
    instead: str = ""

    @property
    def reaction(self) -> str:
        """What comes of it."""
        return self.instead or STOPS[stop_for(self.cause)]


@dataclass(frozen=True)
class DriveGuard:
    """A guard of the drive."""

    fault: FaultCode
    trigger: str
    reaction: str
    test: str


HOST_GUARDS = (
    HostGuard(
        HostCause.FEEDBACK_LOST,
        "nothing was heard from the drive for `lost_ticks` ticks",
        _RETURN,
        _CONNECTING,
        "power, cable and bus of the antenna",
    ),
    HostGuard(
        HostCause.DRIVE_FAULT,
        "the drive reports a fault",
        f"{_RETURN}; else {_OPERATOR}",
        _CONNECTING,
        "the drive's fault: its cause has to go before a reset works",
        "the drive's own reaction",
    ),
    HostGuard(
        HostCause.DRIVE_LEFT_OPERATION,
        "the drive leaves operation by itself",
        _OPERATOR,
        _HOST,
        "enable input, supply and temperature of the drive",
    ),
    HostGuard(
        HostCause.SYNCHRONISATION_TIMEOUT,
        "the drive was not ready (`OPERATION_ENABLED`) within `synchronise_time_s`",
        _OPERATOR,
        _CONNECTING,
        "enable input and supply of the drive",
    ),
    HostGuard(
        HostCause.STOP_TIMEOUT,
        "braking took longer than `stop_time_s`",
        _OPERATOR,
        _HOST,
        "why the axes did not come to rest: gains, load, holding brake",
    ),
    HostGuard(
        HostCause.SET_POINT_LOST,
        "the drive acts on set-points more than `set_point_lag_ticks` ticks late",
        _OPERATOR,
        _HOST,
        "load of the bus, and the rate that the drive can take",
    ),
    HostGuard(
        HostCause.OVERSPEED,
        "the axis turned faster than its limit, `limits.rate_rad_s`, for `debounce_ticks` ticks",
        _OPERATOR,
        _HOST,
        "gains and what was asked for",
    ),
    HostGuard(
        HostCause.FOLLOWING_ERROR,
        "the axis was further from its reference than `limits.following_position_rad` or `following_rate_rad_s` "
        "allows, for `following_time_s`",
        _OPERATOR,
        _HOST,
        "a blocked axis, a torque limit that is reached, the gains",
    ),
    HostGuard(
        HostCause.GYRO_ENCODER_DISAGREE,
        "gyro and encoder tell rates that differ by more than `gyro_encoder_rad_s`",
        _OPERATOR,
        _HOST,
        "sign and mounting of gyro and encoder, a slipping coupling",
    ),
    HostGuard(
        HostCause.SENSOR_DRIFT,
        "gyro and encoder tell angles that move apart by more than `gyro_encoder_rad` and 5 % of the path within 2 s; "
        "without gyros, rate and position of the drive within `one_sensor_window_s` too, but for the rounding of rates",
        _OPERATOR,
        _PLAUSIBLE,
        "bias and scale of the gyro, a slipping coupling, the base rate",
    ),
    HostGuard(
        HostCause.GYRO_STUCK,
        "a gyro that had noise before does not change for `stuck_gyro_ticks`",
        _OPERATOR,
        _PLAUSIBLE,
        "the gyro and its cable",
    ),
    HostGuard(
        HostCause.FEEDBACK_FROZEN,
        "gyro and encoder do not change for `stuck_gyro_ticks`, or tell nothing new for 0.1 s under more torque than "
        "`expectation.disturbance_nm` or, once the axis has moved, twice what was against it (a tenth of that at"
        " least); or the device's tick stands still",
        _OPERATOR,
        _PLAUSIBLE,
        "encoder, gyro and the drive's firmware; a blocked axis",
    ),
    HostGuard(
        HostCause.POSITION_JUMP,
        "in every state: a position over 0.05 rad off the way that the rates explain, over 0.25 rad across a silence",
        _OPERATOR,
        _PLACES,
        "the encoder's cable and index; whether the drive restarted",
    ),
    HostGuard(
        HostCause.RUNAWAY,
        "over 30 ms the axis gains momentum that its torque does not explain (`expectation`), or a quarter of that if"
        " it grew eightfold within 0.3 s and the reversed torque would explain it",
        _OPERATOR,
        _PLAUSIBLE,
        "phases and sign of the motor, sign of the encoder, `expectation`",
    ),
    HostGuard(
        HostCause.TRAVEL,
        "braking distance reaches a soft limit",
        "the next command",
        _HOST,
        "nothing is broken: command a position inside the travel",
        "brakes under control; beyond the margin: fault",
    ),
    HostGuard(
        HostCause.CABLE_WRAP,
        "braking distance reaches the cable's end",
        "the next command",
        _HOST,
        "nothing is broken: command a position nearer to zero",
        "brakes under control; beyond the margin: fault",
    ),
    HostGuard(
        HostCause.TEMPERATURE,
        "winding above `limits.winding_degc`",
        _OPERATOR,
        _HOST,
        "what torque is held, and the cooling",
    ),
    HostGuard(
        HostCause.NOT_A_NUMBER, "a torque that is no number", _OPERATOR, _HOST, "references and gains that were sent"
    ),
    HostGuard(
        HostCause.WRONG_ANTENNA,
        "it reports another protocol version, name, serial number or torque range than the configuration allows",
        _OPERATOR,
        "tests/host/test_identity.py",
        "which antenna is on this link, and `antenna` in the configuration",
    ),
    HostGuard(
        HostCause.FIRST_TEST,
        "the small torque before the first motion turns an axis the wrong way or not at all, or its sensors differ",
        _OPERATOR,
        "tests/host/test_first_test.py",
        "sign, wiring and `expectation` of the axis that the event names",
    ),
    HostGuard(
        HostCause.ATTITUDE_LOST,
        "mode `pointing` without attitude for 0.1 s and `pointing.coast_time_s`",
        "the next command",
        "tests/host/test_pointing.py",
        "the INS and its link",
        "muted, brakes under control",
    ),
    HostGuard(
        HostCause.GUARD,
        "a segment's own bounds",
        "the next command",
        _HOST,
        "the plan's guards, and what the axis did",
        "brakes under control, program ends",
    ),
)

DRIVE_GUARDS = (
    DriveGuard(
        FaultCode.DEADMAN,
        "no fresh set-point for the window",
        "the host's choice",
        "silence_trips_the_deadman_at_the_end_of_its_window",
    ),
    DriveGuard(
        FaultCode.COMMUNICATION,
        "no `drive_control` for 1000 ticks",
        "the host's choice",
        "silence_of_the_requests_is_a_communication_fault",
    ),
    DriveGuard(
        FaultCode.TRAVEL_LIMIT,
        "encoder beyond a limit",
        "winding shorted, brake",
        "travel_beyond_the_upper_limit_is_a_fault",
    ),
    DriveGuard(
        FaultCode.OVERSPEED,
        "joint or gyro above 18 rad/s",
        "winding shorted, brake",
        "a_joint_that_is_too_fast_is_a_fault",
    ),
    DriveGuard(
        FaultCode.SENSORS_DISAGREE,
        "encoder and gyro apart by 4 rad/s",
        "winding shorted, brake",
        "sensors_that_contradict_each_other_are_a_fault",
    ),
    DriveGuard(
        FaultCode.RUNAWAY,
        "over 30 ms more momentum is gained than torque, heaviest weight and friction explain",
        "winding shorted, brake",
        "a_motor_that_turns_the_wrong_way_is_a_fault",
    ),
    DriveGuard(
        FaultCode.OVERTEMPERATURE,
        "winding above 120 degC",
        "winding shorted, brake",
        "a_hot_winding_is_a_fault_in_every_state",
    ),
    DriveGuard(
        FaultCode.UNDERVOLTAGE,
        "supply below 18 V",
        "winding shorted, brake",
        "a_low_supply_is_a_fault_once_the_power_stage_needs_it",
    ),
    DriveGuard(
        FaultCode.ENCODER,
        "at the end of its range",
        "winding shorted, brake",
        "an_encoder_at_the_end_of_its_range_is_a_fault_and_never_wraps",
    ),
    DriveGuard(
        FaultCode.GYRO,
        "at the end of its range",
        "winding shorted, brake",
        "a_gyro_at_the_end_of_its_range_is_a_fault_and_never_wraps",
    ),
    DriveGuard(
        FaultCode.INTERNAL,
        "a motion that is no number",
        "winding shorted, brake",
        "a_motion_that_is_no_number_is_a_fault",
    ),
)
#: faults that the wire has for drives which see them and the virtual antenna has not
NOT_IN_THE_VIRTUAL_ANTENNA = {FaultCode.SENSOR_STUCK, FaultCode.HOLDING_BRAKE}
