from __future__ import annotations

import http.client
import json
import math
import os
import socket
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest

from firmware_protocol.enumerations import DriveState
from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import TICK_ROW, FrameDirection, blocks_of_frames, open_run
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.loop.timing.miss_causes import MISS_CODE, MissCause
from gimbal_hil.realtime.daemon.run import DaemonOptions, run_daemon
from gimbal_hil.realtime.dashboard import PageServer
from gimbal_hil.realtime.dashboard.page import PAGE
from gimbal_hil.realtime.dashboard.server import MOST_CONNECTIONS
from gimbal_hil.realtime.telemetry.live_view import LiveView
from gimbal_hil.realtime.telemetry.records import Exchange
from gimbal_hil.realtime.telemetry.trouble import DRIVE_TOLD

pytestmark = pytest.mark.realtime


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    run = tmp_path_factory.mktemp("page") / "run"
    run_daemon(shipped_settings(), DaemonOptions(run, duration_s=0.4, lockstep=True, quiet=True))
    return run


def exchanges_of(run: Path) -> list[Exchange]:
    log = open_run(run)
    frames = log.frames[log.frames["direction"] == FrameDirection.DEVICE_TO_HOST]
    rows = log.ticks.copy()
    rows["skipped_ticks"][50] = 3
    return [Exchange(row.tobytes(), blocks_of_frames(frames[frames["tick"] == row["tick"]]), b"") for row in rows]


@pytest.fixture
def view(recorded: Path) -> LiveView:
    """A view that has seen a recorded run, with three misses put in."""
    view = LiveView(open_run(recorded).record.header.period_ns)
    for exchange in exchanges_of(recorded):
        view.take([exchange])
    view.miss(3, MISS_CODE[MissCause.BUS_WAIT])
    return view


@pytest.fixture
def server(view: LiveView) -> Iterator[PageServer]:
    server = PageServer(view, 0)
    yield server
    server.close()


def get(server: PageServer, path: str, host: str | None = None) -> tuple[int, bytes]:
    connection = http.client.HTTPConnection("127.0.0.1", urlsplit(server.url).port, timeout=10)
    connection.request("GET", path, headers={"Host": host} if host else {})
    answer = connection.getresponse()
    content = answer.read()
    connection.close()
    return answer.status, content


def test_the_attitude_of_the_base_is_told_as_long_as_navigation_is_heard(recorded: Path) -> None:
    exchanges, view = exchanges_of(recorded), LiveView(1_000_000)
    assert view.status()["base_attitude_rad"] is None
    view.take(exchanges)
    assert view.status()["base_attitude_rad"] == pytest.approx({"roll": 0.0, "pitch": 0.0, "yaw": 0.0}, abs=0.01)
    rows = np.frombuffer(exchanges[-1].row, TICK_ROW).copy()
    rows["time_ns"] += 2_000_000_000
    view.take([Exchange(rows.tobytes(), b"", b"")])
    assert view.status()["base_attitude_rad"] is None


def test_the_view_counts_what_the_run_holds(view: LiveView, recorded: Path) -> None:
    log = open_run(recorded)
    status = view.status()
    assert status["statistics"]["ticks"] == len(log.ticks)
    assert status["statistics"]["missed"] == 3 and status["statistics"]["missed_by_cause"]["bus_wait"] == 3
    assert status["tick"] == log.ticks["tick"][-1]
    assert status["drive_state"] is not None and status["drive_fault"] == "none"
    assert DRIVE_TOLD[DriveState[status["drive_state"].upper()]] == status["drive_told"]
    last = np.abs([status["position_rad"][axis] for axis in ("outer", "inner")])
    assert np.all(last < np.pi)
    trace = view.trace(-1.0)
    assert {len(column) for column in trace.values()} == {len(trace["time_s"])}
    assert len(trace["time_s"]) > 10 and sorted(trace["time_s"]) == trace["time_s"]


def test_the_trace_tells_when_the_antenna_is_muted_and_nothing_where_it_points_nowhere(recorded: Path) -> None:
    exchanges = exchanges_of(recorded)
    third = len(exchanges) // 3
    view = LiveView(1_000_000)
    view.take(exchanges[:third])
    view.pointing_changed({"state": "held", "muted": True})
    view.take(exchanges[third : 2 * third])
    view.pointing_changed({"state": "held", "muted": False})
    view.take(exchanges[2 * third :])
    told = view.trace(-1.0)["muted"]
    muted, held = told.index(1.0), told.index(0.0)
    assert 0 < muted < held
    assert np.all(np.isnan(told[:muted])) and set(told[muted:held]) == {1.0} and set(told[held:]) == {0.0}


def test_the_page_is_one_document_that_needs_no_network(server: PageServer) -> None:
    status, content = get(server, "/")
    assert status == 200 and content.decode() == PAGE
    assert "http" not in PAGE.lower().replace("http-equiv", "")


def test_the_live_data_is_json_also_where_there_is_no_reference(server: PageServer) -> None:
    status, content = get(server, "/live.json?since=-1")
    live = json.loads(content, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    assert status == 200
    assert None in live["trace"]["position_ref_outer"]
    newest = live["trace"]["time_s"][-1]
    assert json.loads(get(server, f"/live.json?since={newest}")[1])["trace"]["time_s"] == []
    assert json.loads(get(server, "/live.json?since=nonsense")[1])["trace"]["time_s"] != []
    assert sum(count for _, count in live["latency_bins_us"]) == live["status"]["statistics"]["ticks"]


def test_metrics_are_what_prometheus_reads(server: PageServer, view: LiveView) -> None:
    parser = pytest.importorskip("prometheus_client.parser", reason="the extra metrics is not installed")
    status, content = get(server, "/metrics")
    assert status == 200
    families = {family.name: family for family in parser.text_string_to_metric_families(content.decode())}
    assert families["gimbal_ticks"].samples[0].value == view.ticks
    missed = {
        sample.labels["cause"]: sample.value
        for sample in families["gimbal_missed_ticks"].samples
        if "cause" in sample.labels
    }
    assert missed["bus_wait"] == 3 and set(missed) == {cause.value for cause in MissCause}
    buckets = [sample for sample in families["gimbal_wake_latency_seconds"].samples if sample.name.endswith("_bucket")]
    counts = [sample.value for sample in buckets]
    assert counts == sorted(counts) and counts[-1] == view.ticks and math.isinf(float(buckets[-1].labels["le"]))
    assert sum(sample.value for sample in families["gimbal_host_state"].samples) == 1


def test_the_guard_that_tripped_and_a_filling_disk_show_on_the_page_and_in_the_metrics(
    server: PageServer, view: LiveView
) -> None:
    parser = pytest.importorskip("prometheus_client.parser", reason="the extra metrics is not installed")
    told = {"lamp": "low", "free_mb": 1500, "problem": None}
    view.recording = lambda: told

    def lamps() -> tuple[dict[str, float], dict[str, float], dict[str, float]]:
        families = {f.name: f for f in parser.text_string_to_metric_families(get(server, "/metrics")[1].decode())}
        names = ("gimbal_guard_tripped", "gimbal_guard_trips", "gimbal_recording_lamp")
        on, trips, recording = (
            {next(iter(s.labels.values())): s.value for s in families[name].samples if s.value} for name in names
        )
        assert families["gimbal_recording_free_bytes"].samples[0].value == told["free_mb"] * 2**20
        return on, trips, recording

    assert lamps() == ({}, {}, {"low": 1.0})
    view.state_changed("fault", "runaway")
    live = json.loads(get(server, "/live.json")[1])
    assert live["status"]["guard"] == "runaway" and live["status"]["guard_trips"] == {"runaway": 1}
    assert live["recording"] == told
    assert lamps() == ({"runaway": 1.0}, {"runaway": 1.0}, {"low": 1.0})
    # reset, and then an operator's stop: the lamp is off, the count stays
    for to, cause in (("waiting", "operator"), ("idle", "none"), ("active", "operator"), ("stopping", "operator")):
        view.state_changed(to, cause)
        assert lamps() == ({}, {"runaway": 1.0}, {"low": 1.0})
    view.state_changed("stopping", "travel")
    assert lamps() == ({"travel": 1.0}, {"runaway": 1.0, "travel": 1.0}, {"low": 1.0})


def test_only_this_machine_is_answered_and_nothing_can_be_commanded(server: PageServer) -> None:
    assert get(server, "/live.json", host="evil.example:80")[0] == 403
    assert get(server, "/nothing")[0] == 404
    connection = http.client.HTTPConnection("127.0.0.1", urlsplit(server.url).port, timeout=10)
    connection.request("POST", "/", body=b"stop")
    assert connection.getresponse().status == 501
    connection.close()


def test_a_port_that_is_taken_is_refused_and_leaves_no_run_folder(server: PageServer, tmp_path: Path) -> None:
    port = urlsplit(server.url).port
    with pytest.raises(BadInputError, match=f"--page: port {port}"):
        run_daemon(
            shipped_settings(),
            DaemonOptions(tmp_path / "run", duration_s=0.1, lockstep=True, quiet=True, page_port=port),
        )
    assert not (tmp_path / "run").exists()


@pytest.mark.heavy
def test_silent_connections_lock_nobody_out_and_use_up_no_descriptors() -> None:
    server = PageServer(LiveView(1_000_000), 0)
    place = urlsplit(server.url)
    silent: list[socket.socket] = []
    try:
        before = len(os.listdir("/proc/self/fd"))
        for _ in range(4 * MOST_CONNECTIONS):
            silent.append(socket.create_connection((place.hostname, place.port)))
            if len(silent) % MOST_CONNECTIONS == 0:
                with urllib.request.urlopen(server.url, timeout=60) as answer:
                    assert answer.status == 200
        # the last one was answered, so all before it have been taken
        held = len(os.listdir("/proc/self/fd")) - before - len(silent)
        assert held <= MOST_CONNECTIONS + 8
    finally:
        for one in silent:
            one.close()
        server.close()
