"""The ways to come to rest: by torque, by the winding, by the brake."""

from __future__ import annotations

import numpy as np

from firmware_protocol.enumerations import BrakeCommand, BrakeState, DriveRequest, DriveState, FaultCode, StopReaction
from tests.device.bench import WINDOW, control
from tests.device.guard_scenarios.expecting import COAST, MakeBench


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
    bench = make(**COAST).enable()
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


def a_reaction_that_does_not_come_to_rest_ends_in_time(make: MakeBench) -> None:
    bench = make(deadman_reaction=StopReaction.BRAKE, reaction_timeout_s=0.1).enable()
    bench.run(WINDOW, None)
    for _ in range(101):
        bench.spin(0, 4.0)
        bench.tick(None)
    assert bench.state is DriveState.FAULT
