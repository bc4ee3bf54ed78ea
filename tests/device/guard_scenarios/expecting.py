"""What the scenarios share."""

from __future__ import annotations

from collections.abc import Callable

from firmware_protocol.enumerations import DriveState, FaultCode, StopReaction
from tests.device.bench import Bench

MakeBench = Callable[..., Bench]
#: settings of a drive that coasts whatever happens, so that no torque of its own hides what the guard did
COAST = {"deadman_reaction": StopReaction.COAST, "fault_reaction": StopReaction.COAST}


def expect_fault(bench: Bench, fault: FaultCode) -> None:
    """The fault in this tick without torque, and latched in the next."""
    assert bench.fault is fault
    assert bench.state is DriveState.FAULT_REACTION_ACTIVE
    assert bench.torque == (0.0, 0.0)
    bench.run(3, (1.0, 1.0))
    assert (bench.state, bench.fault, bench.torque) == (DriveState.FAULT, fault, (0.0, 0.0))
