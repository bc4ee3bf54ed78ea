"""However the shipped antenna is stopped, its unbalanced inner axis stays where it came to rest, and the drive keeps to
its travel.
"""

from __future__ import annotations

import pytest

from firmware_protocol.schema import BrakeState, DriveState, FaultCode
from gimbal_hil.loop.host import AxisCommand, HostState, Mode, Segment, Shape, program_of
from gimbal_hil.loop.settings import DaemonSettings, settings_from_document, shipped_settings
from gimbal_hil.proof.bench.faults import Rig, Transport
from sim_backend.model import shipped_model


def _rig(settings: DaemonSettings | None = None) -> Rig:
    rig = Rig(settings or shipped_settings(), shipped_model(), Transport.CAN, seed=3)
    rig.advance(60)
    assert rig.host.state is HostState.IDLE
    return rig


@pytest.mark.parametrize("how", ["stop", "quick_stop", "silence", "program's end"])
def test_the_inner_axis_stays_where_it_came_to_rest_after(how: str) -> None:
    rig = _rig()
    there = AxisCommand(Mode.POSITION, Shape.SMOOTH, (0.4, 0.8))
    rig.host.command(program_of([Segment(there, there, 1500, switch_off_afterwards=how == "program's end")]))
    rig.advance(1480)
    if how == "silence":
        rig.host_speaks = False
    elif how != "program's end":
        getattr(rig.host, how)()
    motion = rig.advance(8000)
    assert abs(motion[:, 1] - 0.4).max() < 0.02 and abs(motion[-1, 2:]).max() < 1e-3
    assert rig.device.brake(1) is BrakeState.ENGAGED
    if how in ("quick_stop", "silence"):
        assert rig.device.state is not DriveState.OPERATION_ENABLED


def test_the_drive_keeps_the_inner_axis_within_its_travel_where_the_host_does_not() -> None:
    document = shipped_settings().model_dump(mode="json", by_alias=True)
    document["axes"]["inner"]["limits"] |= {"position_low_rad": None, "position_high_rad": None}
    document["axes"]["inner"]["adjustable"] = {}
    rig = _rig(settings_from_document(document, "test"))
    rig.host.command(program_of([Segment(AxisCommand(Mode.POSITION), AxisCommand(Mode.RATE, Shape.HOLD, (1.0,)))]))
    motion = rig.advance(4000)
    assert rig.device.fault is FaultCode.TRAVEL_LIMIT
    assert 2.05 < motion[:, 1].max() < 2.2 and abs(motion[-1, 3]) < 1e-3
