"""One scenario per guard of the drive: what triggers it, what must come of it. Compiled in the tests, interpreted for
the mutants.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from firmware_protocol.enumerations import (
    BrakeCommand,
    BrakeState,
    DriveRequest,
    DriveState,
    FaultCode,
    LimitFlags,
    StopReaction,
)
from firmware_protocol.messages import DeadmanConfig
from sim_backend.device import Spoilt, TravelReaction
from tests.device.bench import WINDOW, Bench, control

MakeBench = Callable[..., Bench]
_COAST = {"deadman_reaction": StopReaction.COAST, "fault_reaction": StopReaction.COAST}


def _expect_fault(bench: Bench, fault: FaultCode) -> None:
    assert bench.fault is fault
    assert bench.state is DriveState.FAULT_REACTION_ACTIVE
    assert bench.torque == (0.0, 0.0)
    bench.run(3, (1.0, 1.0))
    assert (bench.state, bench.fault, bench.torque) == (DriveState.FAULT, fault, (0.0, 0.0))


def silence_trips_the_deadman_at_the_end_of_its_window(make: MakeBench) -> None:
    bench = make(**_COAST).enable()
    bench.tick((1.0, 0.5))
    for left in range(WINDOW - 1, 0, -1):
        status = bench.tick(None)
        assert (status.state, status.deadman_margin_ticks, bench.torque) == (
            DriveState.OPERATION_ENABLED,
            left,
            (1.0, 0.5),
        )
    bench.tick(None)
    _expect_fault(bench, FaultCode.DEADMAN)
    assert bench.run(2 * WINDOW, None).deadman_margin_ticks == 0


def silence_trips_the_deadman_during_a_quick_stop_too(make: MakeBench) -> None:
    bench = make(**_COAST).enable()
    bench.request(DriveRequest.QUICK_STOP)
    bench.run(WINDOW, None)
    _expect_fault(bench, FaultCode.DEADMAN)


def a_repeated_set_point_does_not_feed_the_deadman(make: MakeBench) -> None:
    bench = make(**_COAST).enable()
    for _ in range(WINDOW):
        bench.tick((2.0, 2.0), sequence=bench.sequence)
    assert bench.torque == (0.0, 0.0)
    _expect_fault(bench, FaultCode.DEADMAN)


def a_set_point_from_behind_does_not_feed_the_deadman(make: MakeBench) -> None:
    bench = make(**_COAST).enable()
    for back in range(WINDOW):
        bench.tick((2.0, 2.0), sequence=(bench.sequence - 1 - back) % 1024)
    _expect_fault(bench, FaultCode.DEADMAN)


def a_host_that_started_anew_is_heard_once_the_deadman_has_run_out(make: MakeBench) -> None:
    bench = make(**_COAST).enable()
    bench.run(WINDOW + 2, None)
    bench.tick((0.0, 0.0), sequence=(bench.sequence - 300) % 1024)
    assert bench.status.deadman_margin_ticks == WINDOW


def the_deadman_cannot_be_changed_while_it_guards_torque(make: MakeBench) -> None:
    bench = make(**_COAST).enable()
    bench.tick((0.0, 0.0), DeadmanConfig(200, StopReaction.BRAKE))
    bench.run(WINDOW, None)
    _expect_fault(bench, FaultCode.DEADMAN)


def torque_is_not_switched_on_before_set_points_come(make: MakeBench) -> None:
    bench = make()
    bench.run(12, None)
    for request in (DriveRequest.SHUTDOWN, DriveRequest.SWITCH_ON, DriveRequest.ENABLE_OPERATION):
        bench.request(request, None)
    assert bench.state is DriveState.SWITCHED_ON


def silence_of_the_requests_is_a_communication_fault(make: MakeBench) -> None:
    bench = make(**_COAST, control_silence_ticks=30).enable()
    bench.run(30)
    assert bench.state is DriveState.OPERATION_ENABLED
    bench.tick((1.0, 1.0))
    _expect_fault(bench, FaultCode.COMMUNICATION)


def travel_beyond_the_upper_limit_is_a_fault(make: MakeBench) -> None:
    for axis in (0, 1):
        bench = make(**_COAST, travel=(-0.5, 0.5)).enable()
        bench.place(axis, 0.51)
        bench.tick((-1.0, -1.0))
        _expect_fault(bench, FaultCode.TRAVEL_LIMIT)
        assert bench.status.limits & (LimitFlags.OUTER_TRAVEL_HIGH << (2 * axis))


def travel_beyond_the_lower_limit_is_a_fault(make: MakeBench) -> None:
    for axis in (0, 1):
        bench = make(**_COAST, travel=(-0.5, 0.5)).enable()
        bench.place(axis, -0.51)
        bench.tick((1.0, 1.0))
        _expect_fault(bench, FaultCode.TRAVEL_LIMIT)
        assert bench.status.limits & (LimitFlags.OUTER_TRAVEL_LOW << (2 * axis))


def torque_that_leads_out_of_travel_is_cut(make: MakeBench) -> None:
    for side in (1.0, -1.0):
        bench = make(travel=(-0.5, 0.5), travel_reaction=TravelReaction.CUT_TORQUE).enable()
        for axis in (0, 1):
            bench.place(axis, side * 0.51)
        bench.tick((side * 2.0, side * 2.0))
        assert bench.torque == (0.0, 0.0)
        bench.tick((-side * 2.0, -side * 2.0))
        assert bench.torque == (-side * 2.0, -side * 2.0)
        assert bench.state is DriveState.OPERATION_ENABLED


def cleared_travel_leads_back_in_and_is_a_fault_again_the_next_time(make: MakeBench) -> None:
    bench = make(**_COAST, travel=(-0.5, 0.5))
    bench.place(0, 0.6)
    bench.enable(clear_travel=True)
    bench.request(DriveRequest.NONE, (2.0, 0.0), clear_travel=True)
    assert (bench.state, bench.torque[0]) == (DriveState.OPERATION_ENABLED, 0.0)
    bench.tick((-2.0, 0.0))
    assert bench.torque[0] == -2.0
    bench.place(0, 0.4)
    bench.tick()
    bench.place(0, 0.6)
    bench.tick()
    _expect_fault(bench, FaultCode.TRAVEL_LIMIT)


def travel_that_nobody_cleared_is_a_fault_as_soon_as_torque_is_on(make: MakeBench) -> None:
    bench = make(**_COAST, travel=(-0.5, 0.5))
    bench.place(0, 0.6)
    bench.enable()
    bench.tick((2.0, 0.0))
    _expect_fault(bench, FaultCode.TRAVEL_LIMIT)


def a_joint_that_is_too_fast_is_a_fault(make: MakeBench) -> None:
    # the base turns the other way, so the gyro sees less than the encoder
    for axis, rate in ((0, {"r": -10.0}), (1, {"q": -10.0})):
        bench = make(**_COAST, base={"motion": "constant_rate", "rate_rad_s": rate}).enable()
        bench.spin(axis, 19.0)
        bench.device.drive.joints[axis].gyro = 900000
        bench.tick()
        _expect_fault(bench, FaultCode.OVERSPEED)


def a_gyro_that_sees_too_much_is_a_fault(make: MakeBench) -> None:
    bench = make(**_COAST, base={"motion": "constant_rate", "rate_rad_s": {"r": 19.0}}).enable()
    bench.tick()
    _expect_fault(bench, FaultCode.OVERSPEED)


def torque_that_drives_a_fast_axis_on_is_cut(make: MakeBench) -> None:
    for axis in (0, 1):
        for side in (1.0, -1.0):
            bench = make().enable()
            bench.spin(axis, side * 16.0)
            bench.tick((side * 2.0, side * 2.0))
            assert bench.torque[axis] == 0.0
            assert bench.status.limits & (LimitFlags.OUTER_RATE << axis)
            bench.spin(axis, side * 16.0)
            bench.tick((-side * 2.0, -side * 2.0))
            assert bench.torque[axis] == -side * 2.0
            assert bench.state is DriveState.OPERATION_ENABLED


def torque_is_held_within_its_limit(make: MakeBench) -> None:
    for sign in (1.0, -1.0):
        bench = make().enable()
        bench.tick((sign * 16.0, sign * 10.0))
        assert bench.torque == (sign * 15.5, sign * 6.6)
        assert bench.status.limits == LimitFlags.OUTER_TORQUE | LimitFlags.INNER_TORQUE
        bench.tick((sign * 15.5, sign * 6.6))
        assert bench.status.limits == 0


def the_drives_own_stop_is_held_within_the_torque_limit(make: MakeBench) -> None:
    bench = make(deadman_reaction=StopReaction.GYRO_STOP).enable()
    bench.spin(0, 14.0)
    bench.spin(1, 14.0)
    bench.run(WINDOW, None)
    assert bench.torque == (-15.5, -6.6)
    assert bench.status.limits & (LimitFlags.OUTER_TORQUE | LimitFlags.INNER_TORQUE)


def a_hot_winding_is_a_fault_in_every_state(make: MakeBench) -> None:
    for axis in (0, 1):
        bench = make(**_COAST).enable()
        bench.heat(axis, 121.0)
        bench.run(2)
        _expect_fault(bench, FaultCode.OVERTEMPERATURE)
    bench = make()
    bench.run(12)
    bench.heat(1, 121.0)
    bench.run(4)
    assert (bench.state, bench.fault) == (DriveState.FAULT, FaultCode.OVERTEMPERATURE)


def a_low_supply_is_a_fault_once_the_power_stage_needs_it(make: MakeBench) -> None:
    bench = make(**_COAST).enable()
    bench.device.set_supply(17.9)
    bench.tick((1.0, 1.0))
    _expect_fault(bench, FaultCode.UNDERVOLTAGE)
    bench = make()
    bench.device.set_supply(0.0)
    bench.run(12)
    assert bench.state is DriveState.SWITCH_ON_DISABLED


def an_encoder_at_the_end_of_its_range_is_a_fault_and_never_wraps(make: MakeBench) -> None:
    for sign in (1.0, -1.0):
        bench = make(**_COAST).enable()
        bench.place(0, sign * 60.0)
        bench.tick()
        feedback = bench.answer[[type(m).__name__ for m in bench.answer].index("FeedbackOuter")]
        assert sign * feedback.position_rad > 50.0  # type: ignore[union-attr]
        bench.tick()
        _expect_fault(bench, FaultCode.ENCODER)


def a_gyro_at_the_end_of_its_range_is_a_fault_and_never_wraps(make: MakeBench) -> None:
    for sign in (1.0, -1.0):
        bench = make(**_COAST, base={"motion": "constant_rate", "rate_rad_s": {"r": sign * 25.0}})
        bench.run(12)
        feedback = bench.answer[[type(m).__name__ for m in bench.answer].index("FeedbackOuter")]
        assert sign * feedback.rate_rad_s > 20.9  # type: ignore[union-attr]
        assert (bench.state, bench.fault) == (DriveState.FAULT, FaultCode.GYRO)


def a_motion_that_is_no_number_is_a_fault(make: MakeBench) -> None:
    bench = make(**_COAST).enable()
    bench.spin(1, 1.0)
    bench.device.X[5] = float("nan")
    bench.run(2)
    _expect_fault(bench, FaultCode.INTERNAL)


def an_axis_that_is_not_enabled_gets_no_torque(make: MakeBench) -> None:
    bench = make().enable()
    bench.tick((1.0, 1.0), enable_outer=False)
    assert bench.torque == (0.0, 1.0)
    bench.tick((1.0, 1.0), enable_inner=False)
    assert bench.torque == (1.0, 0.0)


def states_below_operation_enabled_know_no_torque(make: MakeBench) -> None:
    bench = make()
    for request in (DriveRequest.NONE, DriveRequest.SHUTDOWN, DriveRequest.SWITCH_ON):
        bench.run(12, (5.0, 5.0))
        bench.request(request, (5.0, 5.0))
        assert bench.torque == (0.0, 0.0)
    bench.request(DriveRequest.ENABLE_OPERATION, (5.0, 5.0))
    assert bench.torque == (5.0, 5.0)
    bench.request(DriveRequest.DISABLE_OPERATION, (5.0, 5.0))
    assert (bench.state, bench.torque) == (DriveState.SWITCHED_ON, (0.0, 0.0))


def a_fault_latches_when_its_cause_has_gone(make: MakeBench) -> None:
    bench = make(**_COAST).enable()
    bench.run(WINDOW + 2, None)
    for request in DriveRequest:
        bench.request(request)
        assert (bench.state, bench.fault) == (DriveState.FAULT, FaultCode.DEADMAN)


def a_fault_is_reset_by_an_edge_only(make: MakeBench) -> None:
    bench = make(**_COAST).enable()
    bench.tick((0.0, 0.0), control(fault_reset=True))
    bench.run(WINDOW + 2, None)
    for _ in range(3):
        bench.tick((0.0, 0.0), control(fault_reset=True))
        assert bench.state is DriveState.FAULT
    bench.tick((0.0, 0.0), control(fault_reset=False))
    assert bench.state is DriveState.FAULT
    bench.tick((0.0, 0.0), control(fault_reset=True))
    assert (bench.state, bench.fault) == (DriveState.SWITCH_ON_DISABLED, FaultCode.NONE)


def a_reset_level_that_was_never_seen_low_is_no_edge(make: MakeBench) -> None:
    bench = make()
    bench.heat(0, 130.0)
    bench.run(4)
    bench.heat(0, 20.0)
    bench.run(2)
    bench.tick((0.0, 0.0), control(fault_reset=True))
    assert bench.state is DriveState.FAULT


def a_fault_is_not_reset_while_its_cause_is_there(make: MakeBench) -> None:
    bench = make(**_COAST).enable()
    bench.heat(0, 130.0)
    bench.run(4)
    for level in (False, True):
        bench.tick((0.0, 0.0), control(fault_reset=level))
    assert (bench.state, bench.fault) == (DriveState.FAULT, FaultCode.OVERTEMPERATURE)
    bench.heat(0, 30.0)
    bench.tick()
    for level in (False, True):
        bench.tick((0.0, 0.0), control(fault_reset=level))
    assert bench.state is DriveState.SWITCH_ON_DISABLED


def a_quick_stop_outranks_the_request_beside_it(make: MakeBench) -> None:
    bench = make().enable()
    bench.request(DriveRequest.DISABLE_VOLTAGE, quick_stop=True)
    assert bench.state is DriveState.QUICK_STOP_ACTIVE


def a_quick_stop_is_left_through_switch_on_disabled_only(make: MakeBench) -> None:
    bench = make().enable()
    bench.request(DriveRequest.QUICK_STOP)
    upwards = [request for request in DriveRequest if request is not DriveRequest.DISABLE_VOLTAGE]
    for request in upwards:
        bench.request(request)
        assert bench.state is DriveState.QUICK_STOP_ACTIVE
    bench.request(DriveRequest.DISABLE_VOLTAGE)
    assert (bench.state, bench.torque) == (DriveState.SWITCH_ON_DISABLED, (0.0, 0.0))


def a_quick_stop_decelerates_and_holds_against_gravity(make: MakeBench) -> None:
    bench = make(brakes=False).enable()
    bench.spin(0, 4.0)
    bench.spin(1, 4.0)
    bench.request(DriveRequest.QUICK_STOP, (5.0, 5.0))
    bench.run(800)
    held = bench.device.joint_positions
    bench.run(200)
    assert all(abs(rate) < 0.02 for rate in bench.device.joint_rates)
    assert all(abs(now - then) < 2e-3 for now, then in zip(bench.device.joint_positions, held, strict=True))
    assert abs(bench.torque[1]) > 0.1


def a_quick_stop_at_rest_stays_where_it_was(make: MakeBench) -> None:
    bench = make(brakes=False)
    bench.place(1, 0.3)
    bench.enable()
    before = bench.device.joint_positions[1]
    bench.request(DriveRequest.QUICK_STOP)
    bench.run(1000)
    assert abs(bench.device.joint_positions[1] - before) < 2e-3


def coasting_applies_no_torque(make: MakeBench) -> None:
    bench = make(**_COAST).enable()
    bench.spin(0, 4.0)
    bench.run(WINDOW, None)
    assert (bench.fault, bench.torque) == (FaultCode.DEADMAN, (0.0, 0.0))


def a_shorted_winding_stops_an_axis_whose_sensors_lie(make: MakeBench) -> None:
    bench = make(deadman_reaction=StopReaction.BRAKE).enable()
    for _ in range(WINDOW - 1):
        bench.spin(0, 4.0)
        bench.tick(None)
    for _ in range(400):
        # what the drive has read says the opposite of what is true
        bench.device.drive.joints[0].joint_rate = bench.device.drive.joints[0].gyro = -400000
        bench.tick(None)
        assert bench.torque == (0.0, 0.0)
    assert bench.state in (DriveState.FAULT_REACTION_ACTIVE, DriveState.FAULT)
    assert abs(bench.device.joint_rates[0]) < 0.05


def an_axis_that_its_weight_moves_is_held_by_its_brake_without_power(make: MakeBench) -> None:
    for brakes, falls in ((True, False), (False, True)):
        bench = make(deadman_reaction=StopReaction.COAST, brakes=brakes).enable()
        bench.run(WINDOW + 300, None)
        assert bench.state is DriveState.FAULT
        assert (abs(bench.device.joint_positions[1]) > 0.1) is falls
        assert bench.device.brake(1) is (BrakeState.ENGAGED if brakes else BrakeState.ABSENT)
        assert bench.device.brake(0) is BrakeState.ABSENT


def a_drive_without_power_shorts_its_windings(make: MakeBench) -> None:
    bench = make()
    bench.spin(0, 3.0)
    bench.run(300)
    assert bench.state is DriveState.SWITCH_ON_DISABLED and abs(bench.device.joint_rates[0]) < 0.1
    bench.enable()
    assert bench.device.drive.joints[0].shorted == 0


def a_brake_opens_for_torque_and_closes_when_no_axis_is_under_torque(make: MakeBench) -> None:
    bench = make()
    bench.run(30)
    assert bench.device.brake(1) is BrakeState.ENGAGED
    bench.enable()
    assert bench.device.brake(1) is BrakeState.RELEASED
    for _ in range(30):
        bench.tick((0.0, 0.0), enable_outer=True, enable_inner=False)
    assert bench.device.brake(1) is BrakeState.RELEASED
    for _ in range(30):
        bench.tick((0.0, 0.0), enable_outer=False, enable_inner=False)
    assert bench.device.brake(1) is BrakeState.ENGAGED


def a_brake_obeys_its_command(make: MakeBench) -> None:
    bench = make().enable()
    bench.tick((0.0, 0.0), control(brakes=(BrakeCommand.AUTOMATIC, BrakeCommand.ENGAGE)))
    bench.run(30)
    assert bench.device.brake(1) is BrakeState.ENGAGED
    bench.request(DriveRequest.DISABLE_VOLTAGE, brakes=(BrakeCommand.AUTOMATIC, BrakeCommand.RELEASE))
    bench.run(30)
    assert bench.device.brake(1) is BrakeState.RELEASED


def a_brake_stops_a_coasting_axis_and_slips_at_its_torque(make: MakeBench) -> None:
    bench = make(deadman_reaction=StopReaction.COAST).enable()
    for _ in range(WINDOW):
        bench.spin(1, 6.0)
        bench.tick(None)
    speeds = []
    for _ in range(150):
        bench.tick(None)
        speeds.append(abs(bench.device.joint_rates[1]))
    assert max(speeds) > 5.0 and speeds[-1] < 0.01
    # 6.6 N m on 0.07 kg m2, weight and friction beside it
    assert 60.0 < 1000.0 * -np.diff(speeds)[20:50].mean() < 140.0


def a_quick_stop_takes_the_way_that_it_is_asked_for(make: MakeBench) -> None:
    for stop in (StopReaction.COAST, StopReaction.BRAKE, StopReaction.GYRO_STOP):
        bench = make().enable()
        bench.spin(0, 3.0)
        bench.request(DriveRequest.QUICK_STOP, stop=stop)
        bench.tick()
        assert (bench.torque[0] < 0.0) is (stop is StopReaction.GYRO_STOP)
        assert bench.device.drive.joints[0].shorted == (stop is StopReaction.BRAKE)


def a_quick_stop_that_runs_can_be_asked_to_trust_less(make: MakeBench) -> None:
    bench = make().enable()
    bench.spin(0, 3.0)
    bench.request(DriveRequest.QUICK_STOP)
    bench.request(DriveRequest.QUICK_STOP, quick_stop=True, stop=StopReaction.BRAKE)
    assert bench.torque[0] == 0.0 and bench.device.drive.joints[0].shorted == 1
    bench.request(DriveRequest.QUICK_STOP, quick_stop=True, stop=StopReaction.DECELERATE_AND_HOLD)
    assert bench.device.drive.joints[0].shorted == 1


def silence_during_a_stop_without_sensors_does_not_bring_them_back(make: MakeBench) -> None:
    bench = make(deadman_reaction=StopReaction.DECELERATE_AND_HOLD).enable()
    bench.spin(0, 0.5)
    bench.request(DriveRequest.QUICK_STOP, stop=StopReaction.BRAKE)
    for _ in range(2 * WINDOW):
        bench.tick(None)
        assert bench.torque == (0.0, 0.0)
    assert bench.fault is FaultCode.DEADMAN
    # one that trusts the encoder goes on as the host chose for silence
    bench = make(deadman_reaction=StopReaction.BRAKE).enable()
    bench.spin(0, 2.0)
    bench.request(DriveRequest.QUICK_STOP, stop=StopReaction.DECELERATE_AND_HOLD)
    bench.run(WINDOW + 1, None)
    assert bench.torque == (0.0, 0.0) and bench.device.drive.joints[0].shorted == 1


def sensors_that_contradict_each_other_are_a_fault(make: MakeBench) -> None:
    for kind, part in ((Spoilt.REVERSED, "encoder"), (Spoilt.REVERSED, "gyro"), (Spoilt.FROZEN, "encoder")):
        bench = make(**_COAST).enable()
        bench.spin(0, 6.0)
        bench.run(5)
        bench.device.spoil(0, part, kind)
        bench.run(15)
        assert (bench.state, bench.fault) == (DriveState.FAULT, FaultCode.SENSORS_DISAGREE)


def a_stop_uses_no_sensor_while_they_contradict_each_other(make: MakeBench) -> None:
    bench = make().enable()
    bench.device.spoil(0, "encoder", Spoilt.REVERSED)
    bench.spin(0, 1.5)
    bench.run(12)
    bench.request(DriveRequest.QUICK_STOP)
    bench.tick()
    assert bench.torque[0] == 0.0 and bench.device.drive.joints[0].shorted == 1


def a_stop_does_not_use_the_sensor_that_failed(make: MakeBench) -> None:
    bench = make(
        fault_reaction=StopReaction.DECELERATE_AND_HOLD, stop_disagreement_rad_s=1e5, travel=(-100.0, 100.0)
    ).enable()
    bench.spin(0, 3.0)
    bench.place(1, 60.0)
    bench.run(2)
    assert bench.fault is FaultCode.ENCODER
    assert bench.torque[0] == 0.0 and bench.device.drive.joints[0].shorted == 1


def decelerating_holds_for_its_time_and_then_lets_go(make: MakeBench) -> None:
    bench = make(deadman_reaction=StopReaction.DECELERATE_AND_HOLD, hold_s=0.3, brakes=False).enable()
    bench.spin(1, 4.0)
    bench.run(WINDOW + 500, None)
    assert bench.state is DriveState.FAULT_REACTION_ACTIVE
    assert abs(bench.device.joint_rates[1]) < 0.02
    assert abs(bench.torque[1]) > 0.1
    bench.run(500, None)
    assert (bench.state, bench.torque) == (DriveState.FAULT, (0.0, 0.0))


def holding_becomes_braking_when_a_winding_gets_hot(make: MakeBench) -> None:
    bench = make(deadman_reaction=StopReaction.DECELERATE_AND_HOLD, brakes=False).enable()
    bench.run(WINDOW + 300, None)
    assert abs(bench.torque[1]) > 0.1
    bench.heat(0, 130.0)
    bench.spin(1, 0.0)
    bench.run(2, None)
    assert (bench.state, bench.fault) == (DriveState.FAULT_REACTION_ACTIVE, FaultCode.DEADMAN)
    assert abs(bench.torque[1]) < 0.1


def a_motor_that_turns_the_wrong_way_is_a_fault(make: MakeBench) -> None:
    for axis, torque in ((0, 15.0), (1, 6.0)):
        bench = make(brakes=False).enable()
        bench.device.spoil(axis, "motor", Spoilt.REVERSED)
        pair = (torque, 0.0) if axis == 0 else (0.0, torque)
        for _ in range(40):
            bench.tick(pair)
            if bench.fault is not FaultCode.NONE:
                break
        assert (bench.state, bench.fault) == (DriveState.FAULT_REACTION_ACTIVE, FaultCode.RUNAWAY)
        assert abs(bench.device.joint_rates[axis]) < (1.0 if axis == 0 else 2.5)


def torque_that_moves_the_axis_as_it_should_is_no_runaway(make: MakeBench) -> None:
    bench = make(brakes=False).enable()
    for sign in (1.0, -1.0, 1.0):
        bench.run(60, (sign * 15.0, sign * 6.0))
        assert bench.state is DriveState.OPERATION_ENABLED
    bench.run(60, (0.0, 0.0))
    assert bench.state is DriveState.OPERATION_ENABLED


def a_stop_by_torque_that_drives_the_axis_on_becomes_a_short(make: MakeBench) -> None:
    bench = make(deadman_reaction=StopReaction.DECELERATE_AND_HOLD, brakes=False).enable()
    bench.device.spoil(0, "motor", Spoilt.REVERSED)
    bench.spin(0, 3.0)
    bench.run(WINDOW, None)
    assert bench.fault is FaultCode.DEADMAN
    bench.run(60, None)
    assert bench.device.drive.joints[0].shorted == 1 and abs(bench.device.joint_rates[0]) < 3.5


def an_axis_that_ran_away_may_be_reset(make: MakeBench) -> None:
    bench = make(brakes=False).enable()
    bench.device.spoil(0, "motor", Spoilt.REVERSED)
    bench.run(60, (15.0, 0.0))
    assert bench.fault is FaultCode.RUNAWAY
    bench.device.spoil(0, "motor", Spoilt.NOTHING)
    bench.run(3000)
    bench.tick((0.0, 0.0), control())
    bench.tick((0.0, 0.0), control(fault_reset=True))
    assert bench.state is DriveState.SWITCH_ON_DISABLED
    bench.enable()
    bench.run(50, (5.0, 0.0))
    assert bench.state is DriveState.OPERATION_ENABLED


def a_reaction_that_does_not_come_to_rest_ends_in_time(make: MakeBench) -> None:
    bench = make(deadman_reaction=StopReaction.BRAKE, reaction_timeout_s=0.1).enable()
    bench.run(WINDOW, None)
    for _ in range(101):
        bench.spin(0, 4.0)
        bench.tick(None)
    assert bench.state is DriveState.FAULT


SCENARIOS: dict[str, Callable[[MakeBench], None]] = {
    name: scenario
    for name, scenario in list(globals().items())
    if callable(scenario) and not name.startswith("_") and getattr(scenario, "__module__", "") == __name__
}
