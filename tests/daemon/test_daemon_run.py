from __future__ import annotations

import json
import os
import resource
import signal
import stat
import time
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.documents import yaml_text
from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import EventKind, open_run
from gimbal_hil.loop.control.layout import Mode
from gimbal_hil.loop.host.program import AxisCommand, Segment, program_of
from gimbal_hil.loop.host.states import Shape
from gimbal_hil.loop.settings import FirstTestChoice, settings_from_document, shipped_settings
from gimbal_hil.realtime.daemon.run import DaemonOptions, run_daemon
from gimbal_hil.realtime.operator.client import RequestRefusedError
from gimbal_hil.realtime.telemetry import Telemetry
from gimbal_hil.surface.cli.app import run as run_command
from tests.daemon.daemons import PATIENCE_S, Json, RunningDaemon

pytestmark = pytest.mark.realtime

STEP = {"mode": "position", "outer": 0.3, "inner": -0.2}


def torques_after(run: Path, tick: int) -> np.ndarray:
    rows = open_run(run).ticks
    rows = rows[rows["tick"] >= tick]
    return np.stack([rows["torque_outer"], rows["torque_inner"]])


def event_texts(run: Path) -> list[str]:
    lines = (run / "events.jsonl").read_text().splitlines()
    return [json.loads(line)["text"] for line in lines]


def test_a_lockstep_run_ends_by_itself_and_replays_bit_for_bit(tmp_path: Path) -> None:
    run = tmp_path / "run"
    report = run_daemon(shipped_settings(), DaemonOptions(run, duration_s=0.5, lockstep=True, quiet=True))
    assert report.ending.exit_code == 0 and report.recorded
    assert report.statistics.missed == 0
    assert report.frames["good"] > 0 and not any(
        report.frames[bad] for bad in ("crc_errors", "out_of_range", "duplicates", "foreign")
    )
    record = open_run(run).record
    assert record.end is not None and record.end.reason == "the duration is over"
    # that is a quick stop that somebody asked for, and no fault
    assert [event.text for event in open_run(run).events if "quick stop" in event.text] == [
        "idle to quick stop (operator)"
    ]
    assert not [event for event in open_run(run).events if event.kind is EventKind.FAULT]
    assert run_command("replay", [str(run), "--json"]) == 0


def test_a_recording_that_was_closed_before_anybody_asked_for_it_is_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def held_up(telemetry: Telemetry, exit_code: int, reason: str) -> None:
        end(telemetry, exit_code, reason)
        time.sleep(2.0)

    end = Telemetry.end
    monkeypatch.setattr(Telemetry, "end", held_up)
    report = run_daemon(shipped_settings(), DaemonOptions(tmp_path / "run", duration_s=0.1, lockstep=True, quiet=True))
    assert report.recorded and report.ending.exit_code == 0, report.ending


def test_two_lockstep_runs_with_the_same_seed_have_the_same_content(tmp_path: Path) -> None:
    hashes = []
    for name in ("one", "other"):
        run_daemon(shipped_settings(), DaemonOptions(tmp_path / name, duration_s=0.3, lockstep=True, quiet=True))
        end = open_run(tmp_path / name).record.end
        assert end is not None
        hashes.append((end.hashes["ticks"], end.hashes["frames"]))
    assert hashes[0] == hashes[1]


def test_a_run_folder_that_is_taken_is_refused_before_anything_moves(tmp_path: Path) -> None:
    options = DaemonOptions(tmp_path / "run", duration_s=0.01, lockstep=True, quiet=True)
    run_daemon(shipped_settings(), options)
    with pytest.raises(BadInputError, match="already holds a run"):
        run_daemon(shipped_settings(), options)


def test_an_operator_moves_both_axes_and_the_run_replays(tmp_path: Path) -> None:
    run = tmp_path / "run"
    with RunningDaemon(run) as daemon, daemon.client() as client:
        assert stat.S_IMODE((run / "operator.json").stat().st_mode) == 0o600
        daemon.until_state(client, "idle")
        client.when_ready("set_point", **STEP)
        daemon.until_state(client, "active")
        segments = [
            {
                "outer": {"mode": "position", "parameters": [0.1]},
                "duration_s": 0.05,
                "label": 7,
                "switch_off_afterwards": True,
            }
        ]
        client.when_ready("segments", segments=segments)
        ended = client.wait_for_segment(7, timeout_s=60)
        assert ended is not None and ended["data"]["cause"] == "duration"
        daemon.until_state(client, "idle")
        ramp = AxisCommand(Mode.POSITION, Shape.TABLE, (0.01, 1.0), table=np.linspace(0.1, 0.2, 20))
        client.start(program_of([Segment(outer=ramp, duration_ticks=200, label=8)]))
        ended = client.wait_for_segment(8, timeout_s=60)
        assert ended is not None and ended["data"]["cause"] == "duration"
        client.when_ready("mode", outer="rate", inner="off")
        status = daemon.until_state(client, "active")
        assert status["mode"] == {"outer": "rate", "inner": "off"}
        client.request("stop")
        daemon.until_state(client, "idle")
        client.request("shut_down")
        code, answer, _ = daemon.wait()
    assert code == 0 and answer["reason"] == "shut down by the operator"
    assert not (run / "operator.json").exists()
    assert [event.data["command"] for event in open_run(run).commands()][:5] == [
        "start",
        "start",
        "start",
        "start",
        "stop",
    ]
    assert run_command("replay", [str(run), "--json"]) == 0


def test_requests_that_make_no_sense_are_refused_in_one_line_that_names_the_key(tmp_path: Path) -> None:
    with RunningDaemon(tmp_path / "run") as daemon, daemon.client() as client:
        daemon.until_state(client, "idle")
        refused: list[tuple[str, Json, str]] = [
            ("dance", {}, "dance"),
            ("set_point", {"mode": "sideways"}, "set_point.mode"),
            ("set_point", {"mode": "rate", "outer": "fast"}, "set_point.outer"),
            ("set_point", {"mode": "rate", "speed": 1.0}, "set_point.speed"),
            ("segments", {"segments": []}, "segments"),
            ("segments", {"segments": [{"outer": {"shape": "sine", "parameters": [1.0]}}]}, "parameters"),
            ("start", {"program": {"length": 3, "values": [0.0]}}, "program"),
        ]
        for command, fields, words in refused:
            with pytest.raises(RequestRefusedError, match=words) as refusal:
                client.request(command, **fields)
            assert "\n" not in str(refusal.value)
        client.request("quick_stop")
        daemon.until_state(client, "fault")
        with pytest.raises(RequestRefusedError, match="state fault"):
            client.request("set_point", **STEP)
        client.request("fault_reset")
        daemon.until_state(client, "idle")


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_switches_torque_off_with_the_next_tick_and_the_log_says_why(
    tmp_path: Path, number: signal.Signals
) -> None:
    run = tmp_path / "run"
    with RunningDaemon(run) as daemon, daemon.client() as client:
        daemon.until_state(client, "idle")
        client.request("set_point", mode="torque", outer=2.0, inner=0.5)
        daemon.until_state(client, "active")
        os.kill(daemon.process.pid, number)
        code, answer, _ = daemon.wait()
    assert code == 130 and answer["reason"] == number.name and answer["recorded"]
    log = open_run(run)
    stop = next(event for event in log.commands() if event.data["command"] == "quick_stop")
    assert not torques_after(run, stop.tick).any()
    assert torques_after(run, 0).any()
    assert f"stopping: {number.name}" in event_texts(run)
    assert log.record.end is not None and log.record.end.exit_code == 130
    assert run_command("replay", [str(run), "--json"]) == 0


def test_when_the_service_dies_the_daemon_stops_by_itself_and_the_log_says_why(tmp_path: Path) -> None:
    run = tmp_path / "run"
    with RunningDaemon(run) as daemon:
        with daemon.client() as client:
            daemon.until_state(client, "idle")
            client.request("set_point", **STEP)
            daemon.until_state(client, "active")
        os.kill(daemon.service_pid(), signal.SIGKILL)
        code, answer, _ = daemon.wait()
    assert code == 3 and "service process has died" in answer["reason"] and not answer["recorded"]
    assert "service process has died" in event_texts(run)[-1]
    assert open_run(run).record.end is None


def test_when_the_control_process_is_killed_the_log_is_closed_and_says_so(tmp_path: Path) -> None:
    run = tmp_path / "run"
    with RunningDaemon(run) as daemon, daemon.client() as client:
        daemon.until_state(client, "idle")
        client.request("set_point", **STEP)
        daemon.until_state(client, "active")
        os.kill(daemon.process.pid, signal.SIGKILL)
        while (run / "operator.json").exists():
            time.sleep(0.01)
    end = open_run(run).record.end
    assert end is not None and end.exit_code == 3 and "control process ended" in end.reason
    assert run_command("replay", [str(run), "--json"]) == 0


def test_a_signal_stops_a_daemon_whose_service_hangs(tmp_path: Path) -> None:
    run = tmp_path / "run"
    with RunningDaemon(run) as daemon:
        with daemon.client() as client:
            daemon.until_state(client, "idle")
            client.request("set_point", **STEP)
            daemon.until_state(client, "active")
        service = daemon.service_pid()
        os.kill(service, signal.SIGSTOP)
        os.kill(daemon.process.pid, signal.SIGTERM)
        time.sleep(1.0)
        os.kill(service, signal.SIGCONT)
        code, answer, _ = daemon.wait()
    assert code == 130 and answer["recorded"]
    assert open_run(run).record.end is not None


def test_a_recording_that_fails_stops_the_daemon(tmp_path: Path) -> None:
    """The service may not let its files grow any more, as on a full disk."""
    run = tmp_path / "run"
    with RunningDaemon(run) as daemon, daemon.client() as client:
        daemon.until_state(client, "idle")
        resource.prlimit(daemon.service_pid(), resource.RLIMIT_FSIZE, (2048, 2048))
        code, answer, _ = daemon.wait()
    assert code == 3 and "recording failed" in answer["reason"] and "too large" in answer["reason"]
    assert open_run(run).record.end is not None or "too large" in (run / "events.jsonl").read_text()


def test_a_daemon_tries_its_antenna_before_the_first_motion_and_the_run_replays(tmp_path: Path) -> None:
    run = tmp_path / "run"
    settings = shipped_settings()
    tried = settings.supervisor.model_copy(update={"first_test": FirstTestChoice.ALWAYS})
    options = DaemonOptions(run, duration_s=0.8, lockstep=True, quiet=True)
    report = run_daemon(settings.model_copy(update={"supervisor": tried}), options)
    assert report.ending.exit_code == 0
    assert sum("first test: each axis turns" in text for text in event_texts(run)) == 1
    assert torques_after(run, 0).any()
    assert run_command("replay", [str(run), "--json"]) == 0


def test_a_client_sees_when_the_test_before_the_first_motion_is_over(tmp_path: Path) -> None:
    document = shipped_settings().model_dump(mode="json", by_alias=True, exclude_none=True)
    document["supervisor"]["first_test"] = "always"
    configuration = tmp_path / "tried.yaml"
    configuration.write_text(yaml_text(document))
    seen = []
    with RunningDaemon(tmp_path / "run", "--config", str(configuration)) as daemon, daemon.client() as client:
        end = time.monotonic() + PATIENCE_S
        while "passed" not in seen and time.monotonic() < end:
            seen.append(client.request("status")["status"]["first_test"])
            time.sleep(0.01)
        assert daemon.until_state(client, "idle")["first_test"] == "passed"
        assert client.request("stop")["ok"]
    assert set(seen) <= {None, "due", "passed"} and seen[-1] == "passed"


def test_a_daemon_whose_antenna_fails_its_first_test_ends_and_says_why(tmp_path: Path) -> None:
    run = tmp_path / "run"
    document = shipped_settings().model_dump(mode="json", by_alias=True)
    document["supervisor"]["first_test"] = "always"
    document["axes"]["inner"]["expectation"] |= {"inertia_kg_m2": 1.5, "disturbance_nm": 100.0}
    options = DaemonOptions(run, duration_s=0.8, lockstep=True, quiet=True)
    report = run_daemon(settings_from_document(document, "test"), options)
    assert report.ending.exit_code == 3 and "first test: inner moved" in report.ending.reason
    assert run_command("replay", [str(run), "--json"]) == 0
