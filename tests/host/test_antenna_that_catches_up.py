"""An antenna process that was kept from running makes up for the periods that it missed (record 0075): its answers then
come in bunches, and what it measures moves by many periods within one tick of the host.
"""

from __future__ import annotations

import random

import pytest

from gimbal_hil.host import AxisCommand, Host, HostState, Mode, Segment, Shape, program_of
from gimbal_hil.settings import host_configuration, settings_from_document, shipped_settings
from sim_backend.device import Device
from sim_backend.model import shipped_model

STEP_NS = 1_000_000
#: how long an antenna may be silent here, ticks
PATIENCE = {"lost_ticks": 100, "set_point_lag_ticks": 500}


class StarvedAntenna:
    """A host in its ticks beside an antenna that at times does not run, and then answers in bunches, by seed."""

    def __init__(self, seed: int) -> None:
        document = shipped_settings().model_dump(mode="json", by_alias=True)
        document["supervisor"] |= PATIENCE | {"deadman": document["supervisor"]["deadman"] | {"window_ticks": 255}}
        self.host = Host(host_configuration(settings_from_document(document, "starved antenna")))
        self.device = Device(shipped_model(), rate_hz=1000.0, seed=seed)
        self._draw = random.Random(seed)
        self._tick = self._stalled_until = 0
        self._asked: list[bytes] = []
        self._answer = b""

    def run(self, ticks: int, starved: bool) -> None:
        """So many ticks of the host."""
        for _ in range(ticks):
            self._asked.append(self.host.tick(self._tick, self._tick * STEP_NS, self._answer))
            self._tick += 1
            if starved and len(self._asked) == 1 and self._draw.random() < 0.02:
                self._stalled_until = self._tick + self._draw.randrange(2, 90)
            if starved and self._tick < self._stalled_until:
                self._answer = b""
            else:
                # a bunch of what is owed, the newest last
                most = self._draw.randrange(1, 60)
                self._answer = b"".join(self.device.tick(asked) for asked in self._asked[:most])
                del self._asked[:most]


@pytest.mark.parametrize("rate", [0.3, 2.0])
def test_a_healthy_antenna_whose_answers_come_in_bunches_trips_nothing(rate: float) -> None:
    for seed in range(8):
        rig = StarvedAntenna(seed)
        rig.run(100, starved=False)
        assert rig.host.state is HostState.IDLE
        slide = AxisCommand(Mode.RATE, Shape.HOLD, (rate,))
        rig.host.command(program_of([Segment(slide, AxisCommand(Mode.RATE, Shape.HOLD, (0.2 * rate,)), 1000)]))
        rig.run(1000, starved=True)
        events = [event.text for event in rig.host.events()]
        assert rig.host.state is not HostState.FAULT, (seed, rig.host.cause, events[-4:])
