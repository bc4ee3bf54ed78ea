"""A host that is not heard: the deadman, and the age of its requests."""

from __future__ import annotations

from firmware_protocol.enumerations import DriveRequest, DriveState, FaultCode, StopReaction
from firmware_protocol.messages import DeadmanConfig
from tests.device.bench import WINDOW
from tests.device.guard_scenarios.expecting import COAST, MakeBench, expect_fault


def silence_trips_the_deadman_at_the_end_of_its_window(make: MakeBench) -> None:
    bench = make(**COAST).enable()
    bench.tick((1.0, 0.5))
    for left in range(WINDOW - 1, 0, -1):
        status = bench.tick(None)
        assert (status.state, status.deadman_margin_ticks, bench.torque) == (
            DriveState.OPERATION_ENABLED,
            left,
            (1.0, 0.5),
        )
    bench.tick(None)
    expect_fault(bench, FaultCode.DEADMAN)
    assert bench.run(2 * WINDOW, None).deadman_margin_ticks == 0


def silence_trips_the_deadman_during_a_quick_stop_too(make: MakeBench) -> None:
    bench = make(**COAST).enable()
    bench.request(DriveRequest.QUICK_STOP)
    bench.run(WINDOW, None)
    expect_fault(bench, FaultCode.DEADMAN)


def a_repeated_set_point_does_not_feed_the_deadman(make: MakeBench) -> None:
    bench = make(**COAST).enable()
    for _ in range(WINDOW):
        bench.tick((2.0, 2.0), sequence=bench.sequence)
    assert bench.torque == (0.0, 0.0)
    expect_fault(bench, FaultCode.DEADMAN)


def a_set_point_from_behind_does_not_feed_the_deadman(make: MakeBench) -> None:
    bench = make(**COAST).enable()
    for back in range(WINDOW):
        bench.tick((2.0, 2.0), sequence=(bench.sequence - 1 - back) % 1024)
    expect_fault(bench, FaultCode.DEADMAN)


def a_host_that_started_anew_is_heard_once_the_deadman_has_run_out(make: MakeBench) -> None:
    bench = make(**COAST).enable()
    bench.run(WINDOW + 2, None)
    bench.tick((0.0, 0.0), sequence=(bench.sequence - 300) % 1024)
    assert bench.status.deadman_margin_ticks == WINDOW


def the_deadman_cannot_be_changed_while_it_guards_torque(make: MakeBench) -> None:
    bench = make(**COAST).enable()
    bench.tick((0.0, 0.0), DeadmanConfig(200, StopReaction.BRAKE))
    bench.run(WINDOW, None)
    expect_fault(bench, FaultCode.DEADMAN)


def torque_is_not_switched_on_before_set_points_come(make: MakeBench) -> None:
    bench = make()
    bench.run(12, None)
    for request in (DriveRequest.SHUTDOWN, DriveRequest.SWITCH_ON, DriveRequest.ENABLE_OPERATION):
        bench.request(request, None)
    assert bench.state is DriveState.SWITCHED_ON


def silence_of_the_requests_is_a_communication_fault(make: MakeBench) -> None:
    bench = make(**COAST, control_silence_ticks=30).enable()
    bench.run(30)
    assert bench.state is DriveState.OPERATION_ENABLED
    bench.tick((1.0, 1.0))
    expect_fault(bench, FaultCode.COMMUNICATION)


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
