"""The protocol, message by message: who is in control, what becomes of set-points, what is told."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.quaternion import QuaternionBase

from gimbal_hil.realtime.mavlink import NOT_TOLD, Reach, Wish
from gimbal_hil.realtime.mavlink.gimbal import HEARTBEAT_PATIENCE_S, NOBODY, RATE_PATIENCE_S
from tests.mavlink.parts import NAN, STATION, command, dialect, gimbal, heartbeat, pitch_yaw, seen, sent

OTHER = (1, 1)
LOCKS = dialect.GIMBAL_MANAGER_FLAGS_PITCH_LOCK | dialect.GIMBAL_MANAGER_FLAGS_YAW_LOCK
EARTH = dialect.GIMBAL_MANAGER_FLAGS_YAW_IN_EARTH_FRAME
VEHICLE = dialect.GIMBAL_MANAGER_FLAGS_YAW_IN_VEHICLE_FRAME
ACCEPTED, DENIED, UNSUPPORTED = (
    getattr(dialect, f"MAV_RESULT_{word}") for word in ("ACCEPTED", "DENIED", "UNSUPPORTED")
)
CONFIGURE, PITCHYAW = dialect.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE, dialect.MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW
BASE = (0.0, 0.0, 1.0)


def test_a_direction_of_the_joints_goes_to_mode_position_on_the_nearest_turn() -> None:
    assert gimbal().take(pitch_yaw(0.5, -0.2), seen(), 0.0).wish == Wish("position", pytest.approx(0.2), -0.5)
    wound = gimbal().take(pitch_yaw(0.0, -0.2), seen((6.0, 0.0)), 0.0).wish
    assert wound is not None and wound.outer == pytest.approx(0.2 + 2.0 * math.pi)


def test_an_angle_that_is_not_given_stays() -> None:
    wish = gimbal().take(pitch_yaw(NAN, 0.4), seen((0.1, -0.3)), 0.0).wish
    assert wish == Wish("position", pytest.approx(-0.4), pytest.approx(-0.3))


@pytest.mark.parametrize(
    ("flags", "base", "expected"),
    [
        (LOCKS, BASE, Wish("pointing", pytest.approx(-0.4), pytest.approx(-0.2))),
        (LOCKS | EARTH, BASE, Wish("pointing", pytest.approx(-0.4), pytest.approx(-0.2))),
        # yaw is 0.4 to the right of where the vehicle looks, which is 1.0 to the left of north
        (LOCKS | VEHICLE, BASE, Wish("pointing", pytest.approx(0.6), pytest.approx(-0.2))),
        (EARTH, BASE, Wish("position", pytest.approx(-1.4), pytest.approx(-0.2))),
        (LOCKS | VEHICLE, None, None),
        (EARTH, None, None),
        (EARTH | VEHICLE, BASE, None),
        # one lock alone is followed in the frame of the vehicle
        (dialect.GIMBAL_MANAGER_FLAGS_PITCH_LOCK, None, Wish("position", pytest.approx(-0.4), pytest.approx(-0.2))),
    ],
)
def test_locks_and_frames(flags: int, base: Any, expected: Wish | None) -> None:
    assert gimbal().take(pitch_yaw(0.2, 0.4, flags), seen(base=base), 0.0).wish == expected


def test_an_attitude_is_taken_like_its_angles() -> None:
    q = QuaternionBase([0.0, 0.2, 0.4]).q
    message = sent(dialect.MAVLink_gimbal_device_set_attitude_message(1, 154, VEHICLE, list(q), NAN, NAN, NAN))
    wish = gimbal().take(message, seen(), 0.0).wish
    assert wish == Wish("position", pytest.approx(-0.4, abs=1e-6), pytest.approx(-0.2, abs=1e-6))


def test_rates_are_limited_and_end_when_they_are_not_repeated() -> None:
    one = gimbal()
    assert one.take(pitch_yaw(NAN, NAN, 0, (0.3, 9.0)), seen(), 0.0).wish == Wish("rate", -2.0, pytest.approx(-0.3))
    assert one.take(pitch_yaw(NAN, NAN, LOCKS, (NAN, 0.5)), seen(), 0.5).wish == Wish("inertial_rate", -0.5, 0.0)
    assert one.overdue(0.5 + RATE_PATIENCE_S) is None
    late = one.overdue(0.6 + RATE_PATIENCE_S)
    assert late is not None and late[0].is_stop
    assert one.overdue(0.7 + RATE_PATIENCE_S) is None


def test_a_stick_asks_for_a_share_of_the_rate_limits() -> None:
    message = sent(dialect.MAVLink_gimbal_manager_set_manual_control_message(1, 154, 0, 1, -1.0, 0.5, NAN, NAN))
    assert gimbal().take(message, seen(), 0.0).wish == Wish("rate", -0.5, 0.5)


def test_retract_and_neutral_come_before_all_else_and_go_smoothly() -> None:
    one = gimbal()
    wish = one.take(pitch_yaw(0.2, 0.2, dialect.GIMBAL_MANAGER_FLAGS_RETRACT | LOCKS), seen(), 0.0).wish
    assert wish is not None and (wish.mode, wish.outer, wish.inner) == ("position", 1.0, -1.0) and wish.over_s > 2.0
    status = one.due(seen(), 0.0)[1]
    assert status.flags & dialect.GIMBAL_DEVICE_FLAGS_RETRACT
    wish = one.take(pitch_yaw(NAN, NAN, dialect.GIMBAL_MANAGER_FLAGS_NEUTRAL), seen(), 0.0).wish
    assert wish is not None and (wish.outer, wish.inner) == (0.0, 0.0)


def test_one_component_is_in_control_and_others_are_refused() -> None:
    one = gimbal()
    assert one.take(pitch_yaw(0.1, 0.1), seen(), 0.0).wish is not None and one.controller == STATION
    assert one.take(pitch_yaw(0.1, 0.1, sender=OTHER), seen(), 0.1).wish is None
    (ack,) = one.take(command(PITCHYAW, 5.0, 5.0, NAN, NAN, sender=OTHER), seen(), 0.1).answers
    assert (ack.result, ack.target_system, ack.target_component) == (DENIED, *OTHER)
    one.take(command(CONFIGURE, -2.0, 0.0, -1.0, sender=OTHER), seen(), 0.2)
    assert one.controller == OTHER
    assert one.take(pitch_yaw(0.1, 0.1), seen(), 0.3).wish is None


def test_who_gives_up_control_stops_the_motion() -> None:
    one = gimbal()
    one.take(pitch_yaw(0.1, 0.1), seen(), 0.0)
    taken = one.take(command(CONFIGURE, -3.0, 0.0, -1.0), seen(), 0.2)
    assert one.controller == NOBODY and taken.wish is not None and taken.wish.is_stop


def test_a_controller_without_heartbeats_is_gone_and_the_joints_are_stopped() -> None:
    one = gimbal()
    one.take(pitch_yaw(0.1, 0.1), seen(), 0.0)
    one.take(heartbeat(), seen(), 2.0)
    assert one.overdue(2.0 + HEARTBEAT_PATIENCE_S) is None
    late = one.overdue(2.1 + HEARTBEAT_PATIENCE_S)
    assert late is not None and late[0].is_stop and one.controller == NOBODY


def test_what_somebody_without_control_asks_for_leaves_no_trace() -> None:
    one = gimbal()
    one.take(pitch_yaw(0.1, 0.1), seen(), 0.0)
    assert one.take(pitch_yaw(NAN, NAN, rates=(0.0, 0.2), sender=(77, 1)), seen(), 0.1).wish is None
    one.take(heartbeat(), seen(), 1.0)
    # neither the motion of who is in control ends, nor does the other one take over
    assert one.overdue(1.5) is None and one.controller == STATION


def test_who_was_stopped_for_its_silence_is_in_control_again_once_it_is_heard() -> None:
    one = gimbal()
    one.take(pitch_yaw(0.1, 0.1), seen(), 0.0)
    assert one.overdue(0.1 + HEARTBEAT_PATIENCE_S) is not None
    assert one.take(pitch_yaw(0.2, 0.2), seen(), 5.0).wish is None
    asked = one.take(command(PITCHYAW, 10.0, 20.0, NAN, NAN), seen(), 5.0)
    configured = one.take(command(CONFIGURE, -2.0, 0.0, -1.0), seen(), 5.0)
    assert [taken.answers[0].result for taken in (asked, configured)] == [DENIED, DENIED]
    one.take(heartbeat(), seen(), 6.0)
    assert one.take(pitch_yaw(0.2, 0.2), seen(), 6.1).wish is not None and one.controller == STATION


def test_a_controller_that_moved_nothing_stops_nobody_s_motion_when_it_goes() -> None:
    one = gimbal()
    one.take(command(CONFIGURE, -2.0, 0.0, -1.0), seen(), 0.0)
    assert one.controller == STATION
    assert one.overdue(0.1 + HEARTBEAT_PATIENCE_S) is None and one.controller == NOBODY
    one.take(heartbeat(), seen(), 9.0)
    one.take(command(CONFIGURE, -2.0, 0.0, -1.0), seen(), 9.0)
    assert one.take(command(CONFIGURE, -3.0, 0.0, -1.0), seen(), 9.1).wish is None


def test_a_command_is_answered_when_the_daemon_has_answered() -> None:
    one = gimbal()
    taken = one.take(command(PITCHYAW, 10.0, 20.0, NAN, NAN), seen(), 0.0)
    assert taken.answers == () and taken.command == (PITCHYAW, STATION)
    assert taken.wish == Wish("position", pytest.approx(-math.radians(20.0)), pytest.approx(-math.radians(10.0)))
    assert [one.result(taken.command, yes).result for yes in (True, False)] == [ACCEPTED, DENIED]


@pytest.mark.parametrize(
    "name", ["GIMBAL_DEVICE_INFORMATION", "GIMBAL_MANAGER_INFORMATION", "GIMBAL_DEVICE_ATTITUDE_STATUS"]
)
def test_what_is_requested_is_sent(name: str) -> None:
    number = getattr(dialect, f"MAVLINK_MSG_ID_{name}")
    ack, message = gimbal().take(command(dialect.MAV_CMD_REQUEST_MESSAGE, float(number)), seen(), 0.0).answers
    assert ack.result == ACCEPTED and sent(message, (1, 154)).get_type() == name


def test_limits_are_told_the_other_way_round() -> None:
    number = float(dialect.MAVLINK_MSG_ID_GIMBAL_MANAGER_INFORMATION)
    told = gimbal().take(command(dialect.MAV_CMD_REQUEST_MESSAGE, number), seen(), 0.0).answers[1]
    assert (told.pitch_min, told.pitch_max, told.yaw_min, told.yaw_max) == (-0.5, 1.5, -7.0, 3.0)
    assert not told.cap_flags & dialect.GIMBAL_MANAGER_CAP_FLAGS_SUPPORTS_INFINITE_YAW
    free = gimbal(Reach((-math.inf, -1.5), (math.inf, 0.5), (2.0, 1.0), (0.0, 0.0)))
    told = free.take(command(dialect.MAV_CMD_REQUEST_MESSAGE, number), seen(), 0.0).answers[1]
    assert told.cap_flags & dialect.GIMBAL_MANAGER_CAP_FLAGS_SUPPORTS_INFINITE_YAW


def test_an_interval_is_changed_and_switched_off() -> None:
    one, number = gimbal(), float(dialect.MAVLINK_MSG_ID_GIMBAL_DEVICE_ATTITUDE_STATUS)

    def sent_from(begin_s: float) -> int:
        told = [message.get_type() for k in range(64) for message in one.due(seen(), begin_s + k / 64.0)]
        return told.count("GIMBAL_DEVICE_ATTITUDE_STATUS")

    assert sent_from(10.0) == 10
    one.take(command(dialect.MAV_CMD_SET_MESSAGE_INTERVAL, number, 50_000.0), seen(), 20.0)
    assert sent_from(20.0) == 20
    one.take(command(dialect.MAV_CMD_SET_MESSAGE_INTERVAL, number, -1.0), seen(), 30.0)
    assert sent_from(30.0) == 0


@pytest.mark.parametrize(
    ("told", "flag"),
    [
        ({"guard": "runaway"}, "MOTOR_ERROR"),
        ({"guard": "drive_fault", "drive_fault": "undervoltage"}, "POWER_ERROR"),
        ({"guard": "feedback_frozen"}, "ENCODER_ERROR"),
        ({"guard": "feedback_lost"}, "COMMS_ERROR"),
        ({"linked": False}, "COMMS_ERROR"),
        ({"position": (0.0, 0.495)}, "AT_PITCH_LIMIT"),
        ({"position": (-2.995, 0.0)}, "AT_YAW_LIMIT"),
        ({}, None),
    ],
)
def test_faults_have_their_flags(told: dict[str, Any], flag: str | None) -> None:
    status = gimbal().due(seen(**told), 0.0)[1]
    assert status.failure_flags == (getattr(dialect, f"GIMBAL_DEVICE_ERROR_FLAGS_{flag}") if flag else 0)


def test_the_attitude_says_what_is_held_and_in_which_frame() -> None:
    held = gimbal().due(seen((0.3, -0.2), BASE, "pointing"), 0.0)[1]
    assert held.flags == LOCKS | EARTH and held.delta_yaw == pytest.approx(-1.0)
    _, pitch, yaw = QuaternionBase(list(held.q)).euler
    assert (pitch, yaw) == pytest.approx((0.2, -1.3))
    followed = gimbal().due(seen((0.3, -0.2), BASE), 0.0)[1]
    assert followed.flags == VEHICLE
    assert QuaternionBase(list(followed.q)).euler[2] == pytest.approx(-0.3)


def test_before_the_daemon_has_told_anything_the_attitude_is_unknown_and_the_link_is_down() -> None:
    status = gimbal().due(NOT_TOLD, 0.0)[1]
    assert all(math.isnan(value) for value in status.q)
    assert status.failure_flags == dialect.GIMBAL_DEVICE_ERROR_FLAGS_COMMS_ERROR


def test_messages_to_others_come_to_nothing() -> None:
    one = gimbal()
    elsewhere = dialect.MAVLink_command_long_message(2, 154, PITCHYAW, 0, 1.0, 1.0, NAN, NAN, 0.0, 0.0, 0.0)
    device = dialect.MAVLink_gimbal_manager_set_pitchyaw_message(1, 154, 0, 3, 0.1, 0.1, NAN, NAN)
    for message in (elsewhere, device, dialect.MAVLink_attitude_message(0, 0, 0, 0, 0, 0, 0)):
        taken = one.take(sent(message), seen(), 0.0)
        assert taken.wish is None and taken.answers == ()
    (ack,) = one.take(command(dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1.0), seen(), 0.0).answers
    assert ack.result == UNSUPPORTED


ANY = st.floats(width=32)
FLAGS = st.integers(0, 0xFFFF)


@given(st.lists(ANY, min_size=7, max_size=7), st.integers(0, 65535) | st.sampled_from([CONFIGURE, PITCHYAW, 511, 512]))
def test_no_command_does_more_than_a_request_that_the_daemon_can_take(values: list[float], number: int) -> None:
    taken = gimbal().take(command(number, *values), seen(), 0.0)
    assert all(message.pack(dialect.MAVLink(None)) for message in taken.answers)
    _require_finite(taken.wish)


@given(FLAGS, st.lists(ANY, min_size=4, max_size=4), st.lists(ANY, min_size=3, max_size=3), st.booleans())
def test_no_set_point_does_more_than_a_request_that_the_daemon_can_take(
    flags: int, four: list[float], three: list[float], with_base: bool
) -> None:
    now = seen(base=BASE if with_base else None)
    for message in (
        dialect.MAVLink_gimbal_device_set_attitude_message(1, 154, flags, four, *three),
        dialect.MAVLink_gimbal_manager_set_attitude_message(1, 154, flags, 1, four, *three),
        dialect.MAVLink_gimbal_manager_set_pitchyaw_message(1, 154, flags, 1, *four),
        dialect.MAVLink_gimbal_manager_set_manual_control_message(1, 154, flags, 1, *four),
    ):
        _require_finite(gimbal().take(sent(message), now, 0.0).wish)


def _require_finite(wish: Wish | None) -> None:
    assert wish is None or all(math.isfinite(value) for value in (wish.outer, wish.inner, wish.over_s))
