"""The scope: what it triggers on, what it keeps, and that only the token sets it."""

from __future__ import annotations

import http.client
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import RunWriter, open_run, tick_rows
from gimbal_hil.data.runs.header import RunHeader
from gimbal_hil.loop.host import HostState
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.realtime.dashboard import PageServer, ScopeScreen
from gimbal_hil.realtime.operator import Door
from gimbal_hil.realtime.service.excerpts import MOST, Excerpts
from gimbal_hil.realtime.telemetry import Exchange, LiveView, Scope, ScopeState, scope_settings
from gimbal_hil.realtime.telemetry.scope import Capture, capture_columns
from sim_backend.model import shipped_model

PERIOD_NS = 1_000_000
AXES = ("outer", "inner")


def ticks(torque: Sequence[float], first: int = 0, **columns: Sequence[float]) -> list[Exchange]:
    rows = tick_rows(len(torque))
    rows["tick"] = np.arange(first, first + len(torque))
    rows["time_ns"] = rows["tick"] * PERIOD_NS
    rows["torque_outer"] = torque
    for name, values in columns.items():
        rows[name] = values
    return [Exchange(row.tobytes(), b"", b"") for row in rows]


def fed(scope: Scope, exchanges: list[Exchange], batch: int) -> list[Capture]:
    return [c for at in range(0, len(exchanges), batch) for c in scope.take(exchanges[at : at + batch])]


def scope_with(**settings: object) -> Scope:
    scope = Scope(PERIOD_NS, AXES)
    scope.ask(scope_settings({"signal": "torque_outer", "before_s": 0.02, "after_s": 0.03} | settings, AXES))
    return scope


def numbers(capture: Capture) -> list[int]:
    return [exchange.tick for exchange in capture.exchanges]


@pytest.mark.parametrize("batch", [1, 7, 500])
def test_a_break_away_is_caught_once_with_every_tick_before_and_after_it(batch: int) -> None:
    torque = np.where(np.arange(500) < 300, 0.0, 1.0) + np.where(np.arange(500) >= 400, -1.0, 0.0)
    scope = scope_with(mode="single", kind="edge", level=0.5, slope="rising")
    (capture,) = fed(scope, ticks(torque), batch)
    assert capture.trigger_tick == 300 and numbers(capture) == list(range(280, 331))
    assert scope.state is ScopeState.DONE


@pytest.mark.parametrize(
    ("slope", "expected"), [("rising", [100, 300]), ("falling", [200]), ("either", [100, 200, 300])]
)
def test_the_normal_mode_catches_every_edge_of_its_slope(slope: str, expected: list[int]) -> None:
    torque = np.repeat([0.0, 1.0, 0.0, 1.0], 100)
    captures = fed(scope_with(mode="normal", kind="edge", level=0.5, slope=slope), ticks(torque), 9)
    assert [capture.trigger_tick for capture in captures] == expected
    assert [capture.number for capture in captures] == list(range(1, len(expected) + 1))


def test_the_automatic_mode_shows_a_full_screen_where_nothing_triggers() -> None:
    captures = fed(scope_with(mode="auto", kind="edge", level=9.0), ticks(np.zeros(200)), 5)
    assert len(captures) == 3 and all(capture.trigger_tick is None for capture in captures)
    assert len(numbers(captures[-1])) == 51
    assert fed(scope_with(mode="normal", kind="edge", level=9.0), ticks(np.zeros(200)), 5) == []


def test_noise_about_a_level_triggers_once_with_hysteresis() -> None:
    noise = 0.1 * (-1.0) ** np.arange(1000)
    assert len(fed(scope_with(mode="normal", level=0.0), ticks(noise), 50)) > 5
    torque = np.concatenate([noise[:500] - 1.0, noise[:500] + 1.0])
    (capture,) = fed(scope_with(mode="normal", level=0.0, hysteresis=0.5), ticks(torque), 50)
    assert capture.trigger_tick == 500


@pytest.mark.parametrize(
    ("settings", "columns", "expected"),
    [
        ({"kind": "window", "low": -0.5, "high": 0.5}, {}, 250),
        ({"kind": "miss"}, {"skipped_ticks": np.arange(500) == 123}, 123),
        ({"kind": "fault"}, {"host_state": np.where(np.arange(500) < 77, HostState.ACTIVE, HostState.FAULT)}, 77),
    ],
)
def test_windows_misses_and_faults_trigger(
    settings: dict[str, object], columns: dict[str, np.ndarray], expected: int
) -> None:
    torque = np.linspace(0.0, 1.0, 501)[:500]
    torque[250:] += 1e-3
    (capture,) = fed(scope_with(mode="single", **settings), ticks(torque, **columns), 11)
    assert capture.trigger_tick == expected


def test_a_trigger_can_be_bound_to_a_segment_and_the_beginning_of_one_triggers() -> None:
    torque = np.repeat([0.0, 1.0, 0.0, 1.0], 100)
    segment = np.repeat([-1, 3, 3, 4], 100)
    bound = scope_with(mode="normal", level=0.5, slope="either", segment=3)
    assert [one.trigger_tick for one in fed(bound, ticks(torque, segment=segment), 9)] == [100, 200]
    begins = scope_with(mode="normal", kind="segment")
    assert [one.trigger_tick for one in fed(begins, ticks(torque, segment=segment), 9)] == [100, 300]
    only = scope_with(mode="normal", kind="segment", segment=4)
    assert [one.trigger_tick for one in fed(only, ticks(torque, segment=segment), 9)] == [300]


def test_a_trigger_before_a_whole_screen_has_passed_keeps_what_there_is() -> None:
    torque = np.where(np.arange(100) < 5, 0.0, 1.0)
    (capture,) = fed(scope_with(mode="single", level=0.5), ticks(torque), 4)
    assert numbers(capture) == list(range(0, 36))


@pytest.mark.parametrize(("before_s", "after_s", "most"), [(2.0, 0.001, 3), (0.0, 1e-6, 110), (2.0, 1e-6, 3)])
def test_whatever_triggers_captures_take_no_more_than_the_ticks_that_pass(
    before_s: float, after_s: float, most: int
) -> None:
    noise = np.where(np.arange(5000) % 2, 1.0, -1.0)
    captures = fed(scope_with(mode="normal", before_s=before_s, after_s=after_s), ticks(noise), 500)
    assert 2 <= len(captures) <= most
    assert sum(len(capture.exchanges) for capture in captures) < 5000 + 5000
    assert all(capture.trigger_tick in numbers(capture)[:-1] for capture in captures)


def test_captures_of_the_run_before_go_with_it(tmp_path: Path) -> None:
    (capture,) = fed(scope_with(mode="single", level=0.5), ticks([0.0] * 30 + [1.0] * 40), 50)
    RunWriter(tmp_path, header()).close(0, "")
    assert Excerpts(tmp_path, header()).write(capture)
    RunWriter(tmp_path, header(), force=True).close(0, "")
    assert not (tmp_path / "scope").exists()


def test_a_scope_that_is_off_keeps_nothing() -> None:
    scope = Scope(PERIOD_NS, AXES)
    assert fed(scope, ticks(np.arange(100.0)), 10) == [] and not scope._history
    scope.ask(scope_settings({"mode": "single"}, AXES))
    fed(scope, ticks(np.zeros(5000)), 50)
    assert len(scope._history) < 1100
    scope.ask(scope_settings({"mode": "off"}, AXES))
    fed(scope, ticks(np.zeros(100)), 50)
    assert scope.state is ScopeState.OFF and not scope._history


@pytest.mark.parametrize(
    ("document", "where"),
    [
        ({"mode": "sometimes"}, "mode"),
        ({"signal": "torque_nobody"}, "signal"),
        ({"level": "high"}, "level"),
        ({"level": math.nan}, "level"),
        ({"before_s": 100.0}, "before_s"),
        ({"after_s": 0.0}, "after_s"),
        ({"kind": "reversal", "signal": "torque_outer"}, "signal"),
        ({"colour": "red"}, "colour"),
        ({"segment": -1}, "segment"),
        ({"segment": 1.5}, "segment"),
    ],
)
def test_settings_that_make_no_sense_are_refused_by_key(document: dict[str, object], where: str) -> None:
    with pytest.raises(BadInputError, match=where):
        scope_settings(document, AXES)


def header() -> RunHeader:
    settings = shipped_settings()
    return RunHeader(settings.model_dump(mode="json", by_alias=True), shipped_model().document, 1, PERIOD_NS, True)


def test_a_capture_is_kept_as_a_run_that_everyone_reads(tmp_path: Path) -> None:
    torque = np.where(np.arange(500) < 300, 0.0, 1.0)
    (capture,) = fed(scope_with(mode="single", level=0.5), ticks(torque), 50)
    folder = Excerpts(tmp_path, header()).write(capture)
    assert folder == tmp_path / "scope" / "0001"
    run = open_run(folder)
    assert list(run.ticks["tick"]) == list(range(280, 331))
    (event,) = (event for event in run.events if "triggered" in event.text)
    assert event.tick == 300 and event.data["signal"] == "torque_outer"
    assert "torque_outer" in run.record.header.title


def test_a_night_of_captures_does_not_fill_the_disk(tmp_path: Path) -> None:
    (capture,) = fed(scope_with(mode="single", level=0.5), ticks([0.0] * 30 + [1.0] * 40), 50)
    late = Capture(MOST + 1, capture.trigger_tick, capture.exchanges, capture.settings)
    assert Excerpts(tmp_path, header()).write(late) is None and not (tmp_path / "scope").exists()


def test_a_disk_that_refuses_a_capture_does_not_end_the_recording_of_the_run(tmp_path: Path) -> None:
    (capture,) = fed(scope_with(mode="single", level=0.5), ticks([0.0] * 30 + [1.0] * 40), 50)
    (tmp_path / "scope").write_text("a file where the folder would be")
    excerpts = Excerpts(tmp_path, header())
    assert excerpts.write(capture) is None and excerpts.failure


@pytest.fixture
def server(tmp_path: Path) -> Iterator[tuple[PageServer, Scope]]:
    scope = Scope(PERIOD_NS, AXES)
    screen = ScopeScreen(scope)
    server = PageServer(LiveView(PERIOD_NS), 0, Door(tmp_path / "nobody", "secret"), screen)
    yield server, scope
    server.close()


def posted(server: PageServer, path: str, body: object, **headers: str) -> tuple[int, dict[str, object]]:
    connection = http.client.HTTPConnection("127.0.0.1", urlsplit(server.url).port, timeout=10)
    given = {"Content-Type": "application/json", "X-Operator-Token": "secret"} | {
        name.replace("_", "-"): value for name, value in headers.items()
    }
    connection.request("POST", path, body=json.dumps(body), headers=given)
    answer = connection.getresponse()
    content = answer.read()
    connection.close()
    return answer.status, json.loads(content) if content.startswith(b"{") else {}


def test_without_the_token_the_page_only_shows(server: tuple[PageServer, Scope]) -> None:
    page, scope = server
    wanted = {"mode": "single"}
    assert posted(page, "/scope", wanted, X_Operator_Token="guess")[0] == 403
    assert posted(page, "/scope", wanted, X_Operator_Token="")[0] == 403
    # what a form of a foreign page could send
    assert posted(page, "/scope", wanted, Content_Type="text/plain")[0] == 403
    assert posted(page, "/act", {"command": "stop"}, X_Operator_Token="guess")[0] == 403
    assert posted(page, "/scope", wanted, Host="evil.example")[0] == 403
    assert scope._asked is None
    assert posted(page, "/scope", wanted) == (200, {"ok": True})
    assert scope._asked is not None


def test_what_the_page_may_ask_is_short_and_known(server: tuple[PageServer, Scope]) -> None:
    page, _ = server
    for body, word in (({"command": "shut_down"}, "set_point"), ([1], "object"), ({"mode": "maybe"}, "command")):
        status, answer = posted(page, "/act", body)
        assert status == 200 and answer["ok"] is False and word in str(answer["error"])
    assert posted(page, "/act", {"command": "x" * 5000})[0] == 400
    assert posted(page, "/act", {"command": "stop"}, Content_Length="nan")[0] == 400
    status, answer = posted(page, "/act", {"command": "stop"})
    assert answer["ok"] is False and "no daemon listens" in str(answer["error"])


def test_a_screen_gets_a_capture_once(server: tuple[PageServer, Scope]) -> None:
    (capture,) = fed(scope_with(mode="single", level=0.5), ticks([0.0] * 30 + [1.0] * 40), 50)
    screen = ScopeScreen(Scope(PERIOD_NS, AXES))
    assert screen.document(0, AXES)["capture"] is None
    screen.show(capture, "run/scope/0001", None)
    shown = screen.document(0, AXES)["capture"]
    assert shown["number"] == 1 and len(shown["columns"]["time_s"]) == 51
    assert shown["columns"]["time_s"][20] == 0.0 and shown["columns"]["rate_inner"] == [None] * 51
    assert screen.document(1, AXES)["capture"] is None
    assert set(capture_columns(capture, AXES)) > {"time_s", "torque_outer", "computing_us"}


def test_older_captures_can_be_looked_at_again(server: tuple[PageServer, Scope]) -> None:
    page, _ = server
    torque = np.repeat([0.0, 1.0, 0.0, 1.0], 100)
    captures = fed(scope_with(mode="normal", level=0.5, slope="either"), ticks(torque), 50)
    screen = ScopeScreen(Scope(PERIOD_NS, AXES))
    for capture in captures:
        screen.show(capture, f"run/scope/{capture.number:04d}", None)
    assert screen.document(0, AXES)["numbers"] == [1, 2, 3]
    shown = [screen.document(3, AXES, wanted)["capture"] for wanted in (1, 2, 0, 9)]
    assert [one and one["trigger_tick"] for one in shown] == [100, 200, None, None]
    connection = http.client.HTTPConnection("127.0.0.1", urlsplit(page.url).port, timeout=10)
    connection.request("GET", "/scope.json?have=0&show=2")
    assert json.loads(connection.getresponse().read())["numbers"] == []
    connection.close()


def test_a_night_of_long_captures_does_not_fill_the_memory() -> None:
    screen = ScopeScreen(Scope(PERIOD_NS, AXES))
    exchanges = tuple(ticks(np.zeros(20_000)))
    for number in range(1, 9):
        screen.show(Capture(number, None, exchanges, scope_settings({}, AXES)), None, None)
    assert screen.document(8, AXES)["numbers"] == [6, 7, 8]
