"""A host's daemon loop on simulated drives of other makes: it connects, moves, stops, and never leaves torque on."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.adapters import CanFrame
from firmware_protocol.codec import records, unpack
from firmware_protocol.enumerations import DriveState, FaultCode
from firmware_protocol.links import AdapterLinkConfig, DriveSection
from firmware_protocol.messages import DriveStatus, FeedbackOuter, SetPoint
from gimbal_hil.loop import timing
from gimbal_hil.loop.host import HostState
from gimbal_hil.surface.cli.plant_drives import serve_drives
from sim_backend.drives import DriveServer
from sim_backend.model import shipped_model
from tests.adapters.rig import AdapterRig
from tests.adapters.servo import mapped_rig

DRIVES = ("moteus", "odrive", "cia402", "dbc")


@pytest.fixture(params=DRIVES)
def rig(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[AdapterRig]:
    made = mapped_rig(tmp_path) if request.param == "dbc" else AdapterRig(request.param)
    yield made
    made.close()


def test_both_axes_go_where_they_are_asked_through_gear_and_sign(rig: AdapterRig) -> None:
    rig.connected().position(0.4, -0.3).run(3000)
    assert rig.gateway.state is DriveState.OPERATION_ENABLED
    np.testing.assert_allclose(rig.joints, (0.4, -0.3), atol=2e-3)
    assert not [event for event in rig.events if "fault" in event]


def test_a_host_that_falls_silent_leaves_no_torque_on_the_drives(rig: AdapterRig) -> None:
    rig.connected().position(0.4, -0.3).run(300)
    assert not rig.has_no_torque()
    rig.host_speaks = False
    rig.run(30)
    assert rig.gateway.fault is FaultCode.DEADMAN and rig.only_brakes()
    rig.run(1500)
    assert rig.gateway.state is DriveState.FAULT and rig.has_no_torque()


def test_drives_whose_host_is_gone_let_go_by_their_own_watchdog(rig: AdapterRig) -> None:
    rig.connected().position(0.4, -0.3).run(300)
    for _ in range(30):
        rig.gimbal.tick()
    assert rig.only_brakes()
    for _ in range(1500):
        rig.gimbal.tick()
    assert rig.has_no_torque()


def test_a_fault_of_one_drive_stops_both_and_is_reset_on_request(rig: AdapterRig) -> None:
    rig.connected().position(0.4, -0.3).run(300)
    drive = rig.gimbal.drives[1]
    drive.trip(*() if rig.drive in ("cia402", "dbc") else (33,))  # type: ignore[attr-defined]
    rig.run(60)
    assert rig.host.state is HostState.FAULT and rig.gateway.fault is FaultCode.INTERNAL and rig.only_brakes()
    rig.run(1500)
    assert rig.gateway.state is DriveState.FAULT and rig.has_no_torque()
    rig.host.reset_fault()
    rig.run(400)
    assert rig.host.state is HostState.IDLE, rig.events[-6:]
    rig.position(0.1, 0.1).run(2500)
    np.testing.assert_allclose(rig.joints, (0.1, 0.1), atol=2e-3)


def test_a_drive_that_falls_silent_is_lost_feedback_and_torque_goes(rig: AdapterRig) -> None:
    rig.connected().position(0.4, -0.3).run(300)
    identifier_of = {"moteus": lambda i: i >> 8, "odrive": lambda i: i >> 5, "dbc": lambda i: i >> 4 & 0xF}

    def of_the_second(frame: CanFrame) -> bool:
        return identifier_of.get(rig.drive, lambda i: i & 0x7F)(frame.identifier) == 2

    rig.lost = of_the_second
    rig.run(100)
    assert rig.host.state is not HostState.ACTIVE and rig.only_brakes()
    rig.run(1500)
    assert rig.has_no_torque()


def test_no_torque_is_commanded_before_the_host_has_asked_for_any(rig: AdapterRig) -> None:
    for _ in range(500):
        rig.run(1)
        assert rig.has_no_torque()
    assert rig.host.state is HostState.IDLE


def test_a_quick_stop_takes_the_torque_away(rig: AdapterRig) -> None:
    rig.connected().position(0.4, -0.3).run(300)
    rig.host.quick_stop()
    rig.run(30)
    assert rig.gateway.state is not DriveState.OPERATION_ENABLED and rig.only_brakes()
    rig.run(1500)
    assert rig.has_no_torque()


def test_simulated_drives_are_served_with_the_priority_of_a_virtual_antenna(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    order: list[str] = []

    @contextmanager
    def claimed(priority: int, core: int | None) -> Iterator[None]:
        order.append(f"claimed {priority}")
        yield
        order.append("given back")

    monkeypatch.setattr(timing, "real_time", claimed)
    monkeypatch.setattr(DriveServer, "serve", lambda *_: order.append("served"))
    link = AdapterLinkConfig(
        kind="adapter",
        drive="moteus",
        interface="unix",
        channel=str(tmp_path / "drives"),
        rate_hz=500.0,
        drives=[DriveSection(id=1, torque_nm=15.0), DriveSection(id=2, torque_nm=6.0)],
    )
    assert serve_drives(link, shipped_model(), 0, None, True) == 0
    assert order == ["claimed 55", "served", "given back"]


@pytest.mark.parametrize("ticks", range(1, 8))
def test_samples_around_a_host_that_was_kept_from_running_have_the_ticks_at_which_they_were_taken(ticks: int) -> None:
    rig = AdapterRig("moteus").connected().torque(0.5, 0.0).run(500)
    heard: list[tuple[int, float]] = []
    hearing = rig.link.receive

    def listen() -> bytes:
        block = hearing()
        told = [unpack(*one) for one in records(block)]
        heard.extend(
            (status.tick, outer.position_rad)
            for outer, status in itertools.product(told, told)
            if isinstance(outer, FeedbackOuter) and isinstance(status, DriveStatus)
        )
        return block

    rig.link.receive = listen  # type: ignore[method-assign]
    rig.run(20).away(ticks).run(20)
    rig.close()
    tick, position = (np.array(column, float) for column in zip(*heard, strict=True))
    assert tick[-1] - tick[0] == 39 + ticks
    # one smooth motion over those ticks, to a step of the encoder
    wanted = np.polynomial.Polynomial.fit(tick, position, 2)
    assert np.abs(position - wanted(tick)).max() < 0.1 * np.abs(np.diff(position)).max()


def test_a_set_names_the_set_point_whose_torque_brought_the_motion_to_its_sample(rig: AdapterRig) -> None:
    rig.connected().torque(0.0, 0.0).run(200)
    sent: list[tuple[int, float]] = []
    told: list[tuple[int, int, float]] = []
    hearing, saying = rig.link.receive, rig.link.send

    def listen() -> bytes:
        block = hearing()
        found = {type(one): one for one in (unpack(*part) for part in records(block))}
        if DriveStatus in found:
            told.append((found[DriveStatus].tick, found[DriveStatus].last_sequence, found[FeedbackOuter].rate_rad_s))
        return block

    def speak(block: bytes) -> None:
        sent.extend((one.sequence, one.torque_outer_nm) for one in (unpack(*part) for part in records(block))
                    if isinstance(one, SetPoint))  # fmt: skip
        saying(block)

    rig.link.receive, rig.link.send = listen, speak  # type: ignore[method-assign]
    rig.run(20).torque(3.0, 0.0).run(20)
    asked = dict(sent)
    moved = next(place for place, (_, _, rate) in enumerate(told) if abs(rate) > 1e-4)
    first = next(place for place, (_, sequence, _) in enumerate(told) if asked.get(sequence, 0.0) > 0.0)
    assert moved == first
