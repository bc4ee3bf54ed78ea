"""Faults that latch and how they are left, and what a quick stop lets through."""

from __future__ import annotations

from firmware_protocol.enumerations import DriveRequest, DriveState, FaultCode
from tests.device.bench import WINDOW, control
from tests.device.guard_scenarios.expecting import COAST, MakeBench


def a_fault_latches_when_its_cause_has_gone(make: MakeBench) -> None:
    bench = make(**COAST).enable()
    bench.run(WINDOW + 2, None)
    for request in DriveRequest:
        bench.request(request)
        assert (bench.state, bench.fault) == (DriveState.FAULT, FaultCode.DEADMAN)


def a_fault_is_reset_by_an_edge_only(make: MakeBench) -> None:
    bench = make(**COAST).enable()
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
    bench = make(**COAST).enable()
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
