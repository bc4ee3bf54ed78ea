"""What the model lacks shows while the antenna runs, through the frames, and a change of it is told."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.documents import yaml_text
from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.host import AxisCommand, Host, HostState, Mode, Segment, Shape, program_of
from gimbal_hil.loop.settings import DaemonSettings, host_configuration, settings_from_document, shipped_settings
from gimbal_hil.realtime.observing import AxisWatch, LiveObserver, WatchState, observed_model
from gimbal_hil.realtime.telemetry import Exchange
from sim_backend import observer as columns
from sim_backend.device import Device
from sim_backend.model import shipped_model
from sim_backend.observer import ModelObserver
from tests.sim_backend.test_observer import COGGING_NM, with_cogging

TICKS = 24_000
#: when the effect sets in
CHANGE_TICK = 15_000
LOST = range(17_000, 17_004)


def swing(amplitude_rad: float, frequency_hz: float, ticks: int = 0) -> Segment:
    """Both axes, for so many ticks or without end."""
    sine = AxisCommand(Mode.POSITION, Shape.SINE, (0.0, amplitude_rad, frequency_hz, 0.0))
    return Segment(sine, sine, duration_ticks=ticks)


def exchanges(settings: DaemonSettings, change_tick: int | None, *motion: Segment) -> list[Exchange]:
    """Both axes swing slowly under control, unless told otherwise; one axis gets a cogging torque meanwhile, four
    feedbacks are lost.
    """
    host, device = Host(host_configuration(settings), settings.axis_names), Device(shipped_model(), seed=2)
    later = Device(with_cogging(), seed=2)
    program, received, found, asked = program_of(motion or [swing(0.4, 0.1)]), b"", [], False
    for tick in range(TICKS):
        if host.state is HostState.IDLE and not asked:
            host.command(program)
            asked = True
        if tick in LOST:
            received = b""
        sent = host.tick(tick, tick * 1_000_000, received)
        found.append(Exchange(host.row, received, sent))
        if tick == change_tick:
            later.take_over(device)
            device = later
        received = device.tick(sent)
    assert host.state is HostState.ACTIVE
    return found


def fed(observer: LiveObserver, given: list[Exchange]) -> np.ndarray:
    """In pieces of uneven size, as a service gets them."""
    found: list[tuple[float, float]] = []
    at, size = 0, 1
    while at < len(given):
        found += observer.take(given[at : at + size])
        at, size = at + size, size % 13 + 1
    return np.array(found)


def test_an_effect_that_sets_in_is_told_on_its_axis_within_two_seconds_and_not_before() -> None:
    settings = shipped_settings()
    observer = LiveObserver(settings, at_once=True)
    given = exchanges(settings, CHANGE_TICK)
    before = fed(observer, given[:CHANGE_TICK])
    assert observer.changes() == [] and not observer.status()["changed"]
    assert observer.watches["outer"].state is observer.watches["inner"].state is WatchState.USUAL
    told_by = 2000
    fed(observer, given[CHANGE_TICK : CHANGE_TICK + told_by])
    assert [(axis, watch.state) for axis, watch in observer.changes()] == [("outer", WatchState.CHANGED)]
    after = fed(observer, given[CHANGE_TICK + told_by :])
    assert observer.watches["inner"].state is WatchState.USUAL
    settled = before[3000:]
    assert np.all(np.isfinite(settled)) and np.all(np.sqrt(np.mean(settled**2, axis=0)) < 1e-3)
    assert np.sqrt(np.mean(after[:, 0] ** 2)) == pytest.approx(COGGING_NM / math.sqrt(2.0), rel=0.3)
    status = observer.status()
    assert status["state"] == "watching" and status["changed"]
    assert status["axes"]["outer"]["rms_nm"] > 100.0 * status["axes"]["outer"]["usual_nm"]
    # taken as usual it is none any more
    observer.learn_anew()
    assert not observer.status()["changed"]


def test_the_right_model_lacks_nothing_where_the_joints_slide_slowly_and_turn_back() -> None:
    settings = shipped_settings()
    observer = LiveObserver(settings, at_once=True)
    told = fed(observer, exchanges(settings, None, swing(0.4, 0.1, 12_000), swing(0.02, 0.1)))
    assert all(watch.state is WatchState.USUAL for watch in observer.watches.values()) and observer.changes() == []
    assert np.sqrt(np.mean(told[15_000:] ** 2, axis=0)).max() < 1e-4


def test_before_torque_is_on_nothing_is_told() -> None:
    settings = shipped_settings()
    observer = LiveObserver(settings, at_once=True)
    assert observer.status()["state"] == "waiting"
    host, device, received = Host(host_configuration(settings)), Device(shipped_model()), b""
    for tick in range(50):
        sent = host.tick(tick, tick * 1_000_000, received)
        assert np.all(np.isnan(observer.take([Exchange(host.row, received, sent)])))
        received = device.tick(sent)
    assert observer.status()["axes"]["outer"]["missing_torque_nm"] is None


def test_what_a_joint_gives_and_how_long_the_observer_takes_come_from_its_model_and_settings() -> None:
    settings = shipped_settings()
    watches = LiveObserver(settings, at_once=True).watches
    assert watches["outer"].give_rad == pytest.approx(0.2585 / 238.88)
    assert watches["inner"].give_rad == pytest.approx(0.1451 / 271.68)


def feed(watch: AxisWatch, nm: float, travel_rad: float = 0.1, windows: int = 1) -> list[bool]:
    return [watch.take(nm, position) for _ in range(windows) for position in np.linspace(0.0, travel_rad, 10)]


def test_a_change_is_told_once_when_it_comes_and_once_when_it_goes() -> None:
    watch = AxisWatch(10, 2, 1e-3)
    feed(watch, 5.0)  # settles
    feed(watch, 0.01, windows=10)
    assert watch.state is WatchState.USUAL and watch.usual_nm == pytest.approx(0.01)
    assert sum(feed(watch, 0.029)) == 0 and watch.state is WatchState.USUAL
    assert sum(feed(watch, 0.05, windows=5)) == 1 and watch.state is WatchState.CHANGED
    assert sum(feed(watch, 0.025)) == 0 and watch.state is WatchState.CHANGED, "not back at once"
    assert sum(feed(watch, 0.01, windows=5)) == 1 and watch.state is WatchState.USUAL


def test_standing_still_teaches_nothing_and_what_is_less_than_the_least_is_no_change() -> None:
    watch = AxisWatch(10, 2, 1e-3)
    feed(watch, 0.0)
    feed(watch, 1e-5, windows=10)
    assert sum(feed(watch, 9e-4)) == 0 and watch.state is WatchState.USUAL
    assert sum(feed(watch, 0.5, travel_rad=1e-3, windows=20)) == 0 and watch.state is WatchState.USUAL


def test_what_friction_held_is_no_change_until_it_is_forgotten_and_a_change_is_told_after_that() -> None:
    give_rad, settling, held_nm = 0.01, 4, 0.5
    watch = AxisWatch(10, settling, 1e-3)
    watch.give_rad = give_rad
    feed(watch, 0.01, windows=20)
    assert watch.state is WatchState.USUAL
    # two ticks slide as far as the bristles give; five times that, and the ticks in which the observer follows
    unsure, at_rad = 1 + 10 + settling, 0.1
    for _ in range(12):
        assert not any(watch.take(held_nm, at_rad) for _ in range(30)), "stands"
        assert not any(watch.take(held_nm, at_rad + 0.6 * give_rad * tick) for tick in range(unsure))
        at_rad += 0.6 * give_rad * (unsure - 1)
        assert watch.state is WatchState.USUAL and watch.rms_nm == pytest.approx(0.01)
    assert sum(watch.take(held_nm, at_rad + 0.6 * give_rad * tick) for tick in range(1, 15)) == 1
    assert watch.state is WatchState.CHANGED


def test_a_joint_that_trembles_on_its_bristles_does_not_slide() -> None:
    watch = AxisWatch(10, 2, 1e-3)
    watch.give_rad = 0.01
    for tick in range(500):
        watch.take(0.5, 0.009 * (tick % 2))
    assert watch.rms_nm is None


def test_a_model_of_another_antenna_is_refused_and_without_one_there_is_no_observer(tmp_path: Path) -> None:
    document = shipped_settings().model_dump(mode="json", by_alias=True)
    document["link"] = {"kind": "unix", "path": "/tmp/none"}
    assert observed_model(settings_from_document(document, "x")) is None
    assert LiveObserver(settings_from_document(document, "x"), at_once=True).status()["state"] == "off"
    model = dict(shipped_model().document)
    model["axes"] = {"pan": model["axes"]["outer"], "tilt": model["axes"]["inner"] | {"parent": "pan"}}
    (tmp_path / "other.yaml").write_text(yaml_text(model))
    document["observer"] = {"model": "other.yaml"}
    settings = settings_from_document(document, "x", tmp_path)
    assert settings.observed_model == str(tmp_path / "other.yaml"), "the path counts from the configuration"
    with pytest.raises(BadInputError, match=r"observer\.model: .*has the axes pan and tilt; expected a model of outer"):
        observed_model(settings)


@pytest.mark.parametrize("rate_hz", [20.0, 50.0, 1000.0])
def test_it_follows_no_faster_than_its_rate_allows(rate_hz: float) -> None:
    settings = shipped_settings().model_copy(update={"rate_hz": rate_hz})
    observer = ModelObserver(shipped_model(), rate_hz, 2.0 * math.pi * settings.observer_bandwidth_hz)
    rows = np.zeros((1000, columns.INPUTS))
    rows[:, 0] = rows[:, columns.MEASURED] = rows[:, columns.FREE] = 1.0
    rows[:, columns.ENCODER] = 1e-5 * (np.arange(1000) % 2)
    told = observer.observe(rows)[:, columns.MISSING]
    assert np.abs(told[500:]).max() < 2.0 * np.abs(told[:500]).max() + 1e-9


def test_one_that_leaves_all_bounds_has_failed_and_says_so_in_json() -> None:
    settings = shipped_settings()
    observer = LiveObserver(settings, at_once=True)
    given = exchanges(settings, None)[:1200]
    observer.take(given[:1100])
    assert observer.status()["state"] == "watching"
    assert observer._observer is not None
    observer._observer.observe = lambda rows: np.full((len(rows), columns.OUTPUTS), np.nan)  # type: ignore[method-assign]
    assert np.all(np.isnan(observer.take(given[1100:])))
    assert observer.status()["state"] == "failed" and "bounds" in observer.status()["problem"]
    json.dumps(observer.status(), allow_nan=False)


def test_what_sets_in_is_suspected_by_its_name_through_the_frames() -> None:
    settings = shipped_settings()
    observer = LiveObserver(settings, at_once=True)
    brisk = AxisCommand(Mode.POSITION, Shape.SINE, (0.0, 0.5, 0.25, 0.0))
    given = exchanges(settings, CHANGE_TICK, Segment(brisk, brisk, duration_ticks=0))
    fed(observer, given[:CHANGE_TICK])
    assert observer.suspects() == []
    fed(observer, given[CHANGE_TICK:])
    told = observer.suspects()
    assert [(axis, one.cause.value, one.order) for axis, one in told] == [("outer", "ripple", 8)]
    assert told[0][1].size == pytest.approx(COGGING_NM, rel=0.1)
    status = observer.status()["axes"]
    assert status["outer"]["suspected"]["confirmed_by"] == "full_turn" and status["inner"]["suspected"] is None
    observer.learn_anew()
    assert observer.status()["axes"]["outer"]["suspected"] is None
