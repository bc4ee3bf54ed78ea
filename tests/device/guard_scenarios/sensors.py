"""Sensors and motors that cannot be believed."""

from __future__ import annotations

from firmware_protocol.enumerations import DriveRequest, DriveState, FaultCode, StopReaction
from firmware_protocol.schema import POSITION_STEP_RAD
from sim_backend.device import Spoilt
from tests.device.bench import WINDOW, control
from tests.device.guard_scenarios.expecting import COAST, MakeBench, expect_fault


def an_encoder_at_the_end_of_its_range_is_a_fault_and_never_wraps(make: MakeBench) -> None:
    for sign in (1.0, -1.0):
        bench = make(**COAST).enable()
        bench.place(0, sign * 60.0)
        bench.tick()
        feedback = bench.answer[[type(m).__name__ for m in bench.answer].index("FeedbackOuter")]
        assert sign * feedback.position_rad > 50.0  # type: ignore[union-attr]
        bench.tick()
        expect_fault(bench, FaultCode.ENCODER)


def a_gyro_at_the_end_of_its_range_is_a_fault_and_never_wraps(make: MakeBench) -> None:
    for sign in (1.0, -1.0):
        bench = make(**COAST, base={"motion": "constant_rate", "rate_rad_s": {"r": sign * 25.0}})
        bench.run(12)
        feedback = bench.answer[[type(m).__name__ for m in bench.answer].index("FeedbackOuter")]
        assert sign * feedback.rate_rad_s > 20.9  # type: ignore[union-attr]
        assert (bench.state, bench.fault) == (DriveState.FAULT, FaultCode.GYRO)


def a_motion_that_is_no_number_is_a_fault(make: MakeBench) -> None:
    bench = make(**COAST).enable()
    bench.spin(1, 1.0)
    bench.device.X[5] = float("nan")
    bench.run(2)
    expect_fault(bench, FaultCode.INTERNAL)


def sensors_that_contradict_each_other_are_a_fault(make: MakeBench) -> None:
    for kind, part in ((Spoilt.REVERSED, "encoder"), (Spoilt.REVERSED, "gyro"), (Spoilt.FROZEN, "encoder")):
        bench = make(**COAST).enable()
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


def a_false_step_of_the_encoder_as_a_stop_begins_moves_nothing(make: MakeBench) -> None:
    """One tick long or lasting, as the stop begins or some ticks before; an axis at rest stays within what the
    joint's rate is wrong by meanwhile.
    """
    for size_rad, moves_rad in ((3e-3, 10e-3), (-12e-3, 25e-3)):
        for lasts, ticks_before in ((False, 1), (True, 1), (True, 3)):
            bench = make(brakes=False).enable()
            bench.run(3)
            stood = bench.device.joint_positions[0]
            bench.device.spoil(0, "encoder", Spoilt.OFF, round(size_rad / POSITION_STEP_RAD))
            bench.run(ticks_before)
            if not lasts:
                bench.device.spoil(0, "encoder", Spoilt.NOTHING)
            bench.request(DriveRequest.QUICK_STOP)
            bench.run(150)
            assert bench.state is DriveState.QUICK_STOP_ACTIVE
            assert abs(bench.device.joint_positions[0] - stood) < moves_rad, (size_rad, lasts, ticks_before)


def a_ramp_goes_on_from_the_motion_after_the_short_that_stood_in_for_it(make: MakeBench) -> None:
    bench = make(brakes=False).enable()
    bench.request(DriveRequest.QUICK_STOP)
    bench.run(50)
    stood = bench.device.joint_positions[0]
    # the encoder slips while the axis is held: following it back would turn the axis by as much the other way
    bench.device.spoil(0, "encoder", Spoilt.OFF, round(12e-3 / POSITION_STEP_RAD))
    bench.run(2)
    assert bench.device.drive.joints[0].shorted == 1
    bench.run(200)
    assert bench.state is DriveState.QUICK_STOP_ACTIVE and bench.device.drive.joints[0].shorted == 0
    assert -3e-3 < bench.device.joint_positions[0] - stood < 15e-3
