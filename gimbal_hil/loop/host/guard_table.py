"""Every guard of host and drive in one place: what trips it, what comes of it, how it is left, and the test that fails
without it.

`docs/guards.md` is made from this table by `python -m gimbal_hil.loop.host.guard_table`; a test holds the two to each
other, and the table to the causes that there are.
"""

from __future__ import annotations

from dataclasses import dataclass
from textwrap import fill

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
_DRIVE = "tests/device/guard_scenarios"
#: what a stop does, in words
STOPS = {
    StopReaction.COAST: "coasts, brake closes",
    StopReaction.BRAKE: "winding shorted, brake closes: no sensor",
    StopReaction.DECELERATE_AND_HOLD: "ramp to rest by the encoder, held, brake closes",
    StopReaction.GYRO_STOP: "torque against the gyro's rate, brake closes at rest",
}


@dataclass(frozen=True)
class HostGuard:
    """A guard of the host; its reaction follows from the cause (`reactions`)."""

    cause: HostCause
    trigger: str
    reset: str
    test: str
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
    HostGuard(HostCause.FEEDBACK_LOST, "no whole feedback set for `lost_ticks`", _RETURN, _CONNECTING),
    HostGuard(
        HostCause.DRIVE_FAULT,
        "the drive tells a fault",
        f"{_RETURN}; else {_OPERATOR}",
        _CONNECTING,
        "the drive's own reaction",
    ),
    HostGuard(HostCause.DRIVE_LEFT_OPERATION, "the drive leaves operation by itself", _OPERATOR, _HOST),
    HostGuard(
        HostCause.SYNCHRONISATION_TIMEOUT,
        "the drive is not in OPERATION_ENABLED after `synchronise_time_s`",
        _OPERATOR,
        _CONNECTING,
    ),
    HostGuard(HostCause.STOP_TIMEOUT, "braking under control takes longer than `stop_time_s`", _OPERATOR, _HOST),
    HostGuard(HostCause.SET_POINT_LOST, "the drive's echo lags more than `set_point_lag_ticks`", _OPERATOR, _HOST),
    HostGuard(HostCause.OVERSPEED, "joint rate above `limits.rate_rad_s` for `debounce_ticks`", _OPERATOR, _HOST),
    HostGuard(HostCause.FOLLOWING_ERROR, "loop error above its limit for `following_time_s`", _OPERATOR, _HOST),
    HostGuard(
        HostCause.GYRO_ENCODER_DISAGREE, "rates of gyro and encoder apart by `gyro_encoder_rad_s`", _OPERATOR, _HOST
    ),
    HostGuard(
        HostCause.SENSOR_DRIFT,
        "angles of gyro and encoder apart by `gyro_encoder_rad` and 5 % of the path, 2 s window",
        _OPERATOR,
        _PLAUSIBLE,
    ),
    HostGuard(
        HostCause.GYRO_STUCK,
        "a gyro that had noise before does not change for `stuck_gyro_ticks`",
        _OPERATOR,
        _PLAUSIBLE,
    ),
    HostGuard(
        HostCause.FEEDBACK_FROZEN,
        "gyro and encoder do not change for `stuck_gyro_ticks`, or for 0.1 s under more torque than "
        "`expectation.disturbance_nm`, or the device's tick stands still",
        _OPERATOR,
        _PLAUSIBLE,
    ),
    HostGuard(
        HostCause.POSITION_JUMP,
        "in every state: a position over 0.05 rad off the way that the rates explain, over 0.25 rad across a silence",
        _OPERATOR,
        _PLACES,
    ),
    HostGuard(
        HostCause.RUNAWAY,
        "over 30 ms the axis gains momentum that its torque does not explain (`expectation`), or a quarter of that"
        " which grew eightfold out of quiet while the torque turned round explained it",
        _OPERATOR,
        _PLAUSIBLE,
    ),
    HostGuard(
        HostCause.TRAVEL,
        "braking distance reaches a soft limit",
        "the next command",
        _HOST,
        "brakes under control; beyond the margin: fault",
    ),
    HostGuard(
        HostCause.CABLE_WRAP,
        "braking distance reaches the cable's end",
        "the next command",
        _HOST,
        "brakes under control; beyond the margin: fault",
    ),
    HostGuard(HostCause.TEMPERATURE, "winding above `limits.winding_degc`", _OPERATOR, _HOST),
    HostGuard(HostCause.NOT_A_NUMBER, "a torque that is no number", _OPERATOR, _HOST),
    HostGuard(
        HostCause.WRONG_ANTENNA,
        "it reports another protocol version, name, serial number or torque range than the configuration allows",
        _OPERATOR,
        "tests/host/test_identity.py",
    ),
    HostGuard(
        HostCause.FIRST_TEST,
        "the small torque before the first motion turns an axis the wrong way or not at all, or its sensors differ",
        _OPERATOR,
        "tests/host/test_first_test.py",
    ),
    HostGuard(
        HostCause.ATTITUDE_LOST,
        "mode `pointing` without attitude for 0.1 s and `pointing.coast_time_s`",
        "the next command",
        "tests/host/test_pointing.py",
        "muted, brakes under control",
    ),
    HostGuard(
        HostCause.GUARD, "a segment's own bounds", "the next command", _HOST, "brakes under control, program ends"
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

_HEAD = """# Guards

Made from `gimbal_hil/loop/host/guard_table.py` by `python -m gimbal_hil.loop.host.guard_table`; do not edit.

A stop never uses the sensor that is in doubt: the host chooses the stop by the cause and requests it from the drive
(`drive_control.stop`). If encoder and gyro differ by more than 1 rad/s, the drive's own stop uses neither and shorts
the windings, whatever was requested; a difference of 4 rad/s is a fault (`SENSORS_DISAGREE`). An axis that its weight
can move has a holding brake, which is closed whenever no axis is under torque; without power the windings are shorted.
No guard detects an encoder or gyro error of less than 0.015 rad/s, or of less than 5 % of the rate.

"""


def _filled(*parts: str) -> str:
    return fill(" ".join(parts), width=120, break_on_hyphens=False, break_long_words=False)


def guard_page() -> str:
    """Text of `docs/guards.md`."""
    lines = ["## Host", "", "| cause | trigger | reaction | left by | test |", "|---|---|---|---|---|"]
    lines += [f"| `{g.cause.name}` | {g.trigger} | {g.reaction} | {g.reset} | `{g.test}` |" for g in HOST_GUARDS]
    lines += [
        "",
        _filled(
            "An operator's `quick-stop` has the cause `OPERATOR`: ramp to rest by the encoder, held, brake closes;",
            "left by `reset`. In a fault that would end by itself (lost feedback, the drive's deadman) it takes that",
            "away: the drive goes on stopping as it does, and only `reset` leads back",
            "(`tests/host/test_supervisor.py`).",
            "Keys and their shipped values are in [the configuration](configuration.md).",
        ),
        "",
        "In addition, torque on the wire is limited; an axis without torque that passes a soft limit is reported as an",
        f"event (`{_PLAUSIBLE}`);",
        "a service process that dies or does no work for `service_timeout_s` ends the daemon (exit 3).",
    ]
    lines += ["", "## Drive", "", "| fault | trigger | reaction | test |", "|---|---|---|---|"]
    lines += [f"| `{g.fault.name}` | {g.trigger} | {g.reaction} | `{g.test}` |" for g in DRIVE_GUARDS]
    lines += [
        "",
        "`SENSOR_STUCK` and `HOLDING_BRAKE` are for other drives; the virtual antenna does not raise them.",
        "A fault latches; it is reset by an edge of `fault_reset` once its cause has gone.",
        f"The tests are in `{_DRIVE}`.",
    ]
    return _HEAD + "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(guard_page(), end="")
