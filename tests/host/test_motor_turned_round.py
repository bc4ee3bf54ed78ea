"""A motor that is turned round while its axis is held still: at first nothing but noise moves it."""

from __future__ import annotations

import pytest

from firmware_protocol.enumerations import DriveState
from gimbal_hil.loop.host import HostState, Mode
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.proof.bench.faults import Rig, Transport
from sim_backend.device import Spoilt
from sim_backend.model import shipped_model
from tests.host.host_loop import hold, one_program


@pytest.mark.parametrize("seed", range(100, 108))
def test_an_axis_is_stopped_before_it_turns_noticeably_whatever_noise_it_starts_from(seed: int) -> None:
    rig = Rig(shipped_settings(), shipped_model(), Transport.SERIAL, seed=seed)
    rig.advance(60)
    rig.host.command(one_program(hold(Mode.POSITION)))
    rig.advance(300)
    rig.device.spoil(0, "motor", Spoilt.REVERSED)
    fastest, ticks = 0.0, 0
    while rig.device.state is DriveState.OPERATION_ENABLED and ticks < 200:
        fastest, ticks = max(fastest, abs(float(rig.advance(1)[0, 2]))), ticks + 1
    assert rig.host.state is HostState.FAULT
    assert ticks < 80 and fastest < 0.03
