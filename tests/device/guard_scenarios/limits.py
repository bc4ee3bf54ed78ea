"""Bounds that the drive keeps: travel, speed, torque, heat, supply, and who may have torque at all."""

from __future__ import annotations

from firmware_protocol.enumerations import DriveRequest, DriveState, FaultCode, LimitFlags, StopReaction
from sim_backend.device import TravelReaction
from tests.device.bench import WINDOW
from tests.device.guard_scenarios.expecting import COAST, MakeBench, expect_fault


def travel_beyond_the_upper_limit_is_a_fault(make: MakeBench) -> None:
    for axis in (0, 1):
        bench = make(**COAST, travel=(-0.5, 0.5)).enable()
        bench.place(axis, 0.51)
        bench.tick((-1.0, -1.0))
        expect_fault(bench, FaultCode.TRAVEL_LIMIT)
        assert bench.status.limits & (LimitFlags.OUTER_TRAVEL_HIGH << (2 * axis))


def travel_beyond_the_lower_limit_is_a_fault(make: MakeBench) -> None:
    for axis in (0, 1):
        bench = make(**COAST, travel=(-0.5, 0.5)).enable()
        bench.place(axis, -0.51)
        bench.tick((1.0, 1.0))
        expect_fault(bench, FaultCode.TRAVEL_LIMIT)
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
    bench = make(**COAST, travel=(-0.5, 0.5))
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
    expect_fault(bench, FaultCode.TRAVEL_LIMIT)


def travel_that_nobody_cleared_is_a_fault_as_soon_as_torque_is_on(make: MakeBench) -> None:
    bench = make(**COAST, travel=(-0.5, 0.5))
    bench.place(0, 0.6)
    bench.enable()
    bench.tick((2.0, 0.0))
    expect_fault(bench, FaultCode.TRAVEL_LIMIT)


def a_joint_that_is_too_fast_is_a_fault(make: MakeBench) -> None:
    # the base turns the other way, so the gyro sees less than the encoder
    for axis, rate in ((0, {"r": -10.0}), (1, {"q": -10.0})):
        bench = make(**COAST, base={"motion": "constant_rate", "rate_rad_s": rate}).enable()
        bench.spin(axis, 19.0)
        bench.device.drive.joints[axis].gyro = 900000
        bench.tick()
        expect_fault(bench, FaultCode.OVERSPEED)


def a_gyro_that_sees_too_much_is_a_fault(make: MakeBench) -> None:
    bench = make(**COAST, base={"motion": "constant_rate", "rate_rad_s": {"r": 19.0}}).enable()
    bench.tick()
    expect_fault(bench, FaultCode.OVERSPEED)


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
        bench = make(**COAST).enable()
        bench.heat(axis, 121.0)
        bench.run(2)
        expect_fault(bench, FaultCode.OVERTEMPERATURE)
    bench = make()
    bench.run(12)
    bench.heat(1, 121.0)
    bench.run(4)
    assert (bench.state, bench.fault) == (DriveState.FAULT, FaultCode.OVERTEMPERATURE)


def a_low_supply_is_a_fault_once_the_power_stage_needs_it(make: MakeBench) -> None:
    bench = make(**COAST).enable()
    bench.device.set_supply(17.9)
    bench.tick((1.0, 1.0))
    expect_fault(bench, FaultCode.UNDERVOLTAGE)
    bench = make()
    bench.device.set_supply(0.0)
    bench.run(12)
    assert bench.state is DriveState.SWITCH_ON_DISABLED


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
