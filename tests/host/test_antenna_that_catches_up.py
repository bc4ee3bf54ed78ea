"""An antenna process that was kept from running makes up for the periods that it missed (record 0075): its answers then
come in bunches, and what it measures moves by many periods within one tick of the host.
"""

from __future__ import annotations

import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import mail as m
from gimbal_hil.loop.control.layout import TORQUE
from gimbal_hil.loop.host import AxisCommand, Host, HostState, Mode, Segment, Shape, layout, program_of
from gimbal_hil.loop.host.plausibility import watch_sensors
from gimbal_hil.loop.host.reception import receive
from gimbal_hil.loop.host.states import LinkStatus
from gimbal_hil.loop.settings import host_configuration, settings_from_document, shipped_settings
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


class Windows:
    """The guards' windows over samples that are made up, beside a host that asks for one torque on both axes."""

    def __init__(self, torque_nm: float = 1.2) -> None:
        self.host = Host(host_configuration(shipped_settings()))
        self.H, self.G, self.C = self.host.memory.H, self.host.memory.G, self.host.memory.C
        self.C[layout.EXPECTS_WEIGHT] = 0.0
        for axis in range(2):
            self.H[layout.axis_h(axis) + TORQUE] = torque_nm
            self.G[layout.axis_g(axis) + layout.MODE] = 1
        watch_sensors(self.H, self.G, self.C, True, 1)

    def sample(self, ticks: int, moved_rad: float, gained_rad_s: float) -> Windows:
        """One sample, so many ticks after the one before."""
        for axis in range(2):
            h = layout.axis_h(axis)
            self.H[h + layout.LAST_POSITION] = self.H[h + layout.MEASURED_POSITION]
            self.H[h + layout.MEASURED_POSITION] += moved_rad
            self.H[h + layout.MEASURED_RATE] += gained_rad_s
        watch_sensors(self.H, self.G, self.C, False, ticks)
        return self

    def of(self, *names: int) -> list[float]:
        """What the windows of both axes hold."""
        return [float(self.H[layout.axis_h(axis) + name]) for axis in range(2) for name in names]


@given(st.integers(1, 90), st.floats(-0.05, 0.05), st.integers(1, 5))
def test_one_sample_that_spans_many_ticks_leaves_the_windows_of_as_many_samples(
    ticks: int, moved_rad: float, begun: int
) -> None:
    names = (layout.DRIFT, layout.PATH, layout.MOMENTUM, layout.IMPULSE, layout.EFFORT)
    apart, together = Windows(), Windows()
    for windows in (apart, together):
        for _ in range(begun):
            windows.sample(1, 0.001, 0.0)
    for _ in range(ticks):
        apart.sample(1, moved_rad / ticks, 0.0)
    together.sample(ticks, moved_rad, 0.0)
    assert together.of(*names) == pytest.approx(apart.of(*names), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(("unheard", "ticks", "late"), [(0, 1, 3), (2, 1, 3), (7, 1, 8), (0, 12, 13), (20, 12, 21)])
def test_a_torque_may_act_as_late_as_the_echo_lags_or_as_a_sample_spans(unheard: int, ticks: int, late: int) -> None:
    windows = Windows(torque_nm=-1.2)
    windows.G[layout.SENT_SEQUENCE], windows.G[layout.LAST_SEQUENCE] = 3, (3 - unheard) & 1023
    windows.sample(ticks, 0.0, 0.0)
    assert windows.of(layout.LATE_IMPULSE) == pytest.approx([1.2e-3 * late] * 2)
    windows.G[layout.LAST_SEQUENCE] = 3
    for axis in range(2):
        windows.H[layout.axis_h(axis) + TORQUE] = 0.0
    windows.sample(1, 0.0, 0.0)
    kept = float(windows.C[layout.MOMENTUM_KEPT])
    assert windows.of(layout.LATE_IMPULSE) == pytest.approx([1.2e-3 * late * kept] * 2)


def test_the_time_between_samples_is_counted_by_the_antenna_and_by_the_host_where_that_stands_still() -> None:
    """An axis that moves by 0.002 rad a tick of the antenna, heard whole in every second tick of the host."""
    for periods, rate in ((1, 2.0), (7, 2.0), (2040, 2.0), (0, 2.0 * 7)):
        memory = Host(host_configuration(shipped_settings())).memory
        memory.G[layout.LINK_STATUS], memory.C[layout.PLAUSIBILITY_SHARE] = int(LinkStatus.OK), 1.0
        mail = np.zeros(m.MAIL_SIZE, dtype=np.int64)
        moved, whole = 0, np.array([m.FEEDBACK_OUTER, m.FEEDBACK_INNER, m.DRIVE_STATUS])
        for tick in range(6):
            mail[whole] = 0
            mail[whole if tick % 2 else m.DRIVE_STATUS] = 1
            mail[m.DRIVE_STATUS_TICK] = (mail[m.DRIVE_STATUS_TICK] + periods) & 4095
            moved += periods or 7
            mail[m.FEEDBACK_OUTER_POSITION] = round(0.002 * moved / m.FEEDBACK_OUTER_POSITION_STEP)
            receive(mail, memory.H, memory.G, memory.C)
        assert memory.H[layout.axis_h(0) + layout.ENCODER_RATE] == pytest.approx(rate, rel=0.01)
