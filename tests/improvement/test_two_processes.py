"""An improvement through its own daemon and an antenna in another process, over a Unix socket, in real time."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml

from gimbal_hil.data.runs import open_run
from gimbal_hil.data.runs.frame_columns import columns_of
from gimbal_hil.knowledge.improvement import Measured, Stopped, read_journal
from gimbal_hil.loop.settings import shipped_settings_path
from sim_backend.model import shipped_model

pytestmark = pytest.mark.realtime

COGGING = {"amplitude": 0.03, "order": 12.0, "phase": 0.7}
#: a machine that stalls for longer than the antenna's deadman stops an experiment, as it should; then the improvement
#: is resumed
TRIES = 30
_MAIN = "from gimbal_hil.surface.cli import main; main()"
_SHORT = ("--survey", "12", "--json")


def configuration(folder: Path) -> Path:
    """A daemon on a Unix socket; host and antenna wait longer for each other, since stalls of a busy machine are not
    under test.
    """
    document = yaml.safe_load(shipped_settings_path().read_text())
    document["link"] = {"kind": "unix", "path": str(folder / "antenna")}
    document["supervisor"] |= {
        "lost_ticks": 100,
        "set_point_lag_ticks": 500,
        "deadman": {"window_ticks": 250, "reaction": "decelerate_and_hold"},
    }
    path = folder / "daemon.yaml"
    path.write_text(yaml.safe_dump(document))
    return path


def plant(folder: Path) -> subprocess.Popen[str]:
    """`gimbal-hil plant` with a hidden effect, ready."""
    hidden = folder / "hidden.yaml"
    hidden.write_text(shipped_model().with_effect("cogging", "outer", COGGING).to_yaml())
    words = [
        "plant",
        "--model",
        str(hidden),
        "--link",
        f"unix:{folder / 'antenna'}",
        "--json",
        "--ready-file",
        str(folder / "ready"),
    ]
    process = subprocess.Popen(
        [sys.executable, "-c", _MAIN, *words], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    assert process.stdout and json.loads(process.stdout.readline())["event"] == "ready"
    return process


def improve(config: Path, out: Path) -> list[str]:
    """The words of an improvement by short surveys in a process of its own."""
    return [sys.executable, "-c", _MAIN, "improve", "--config", str(config), "--out", str(out), *_SHORT]


@pytest.mark.heavy
def test_an_improvement_in_real_time_survives_ctrl_c_and_finds_the_effect_hidden_in_the_other_process(
    tmp_path: Path,
) -> None:
    config, out = configuration(tmp_path), tmp_path / "out"
    antenna = plant(tmp_path)
    words = improve(config, out)
    journal = out / "journal.jsonl"
    try:
        first = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while first.poll() is None and not (out / "round_1" / "survey" / "checkpoint.json").exists():
            time.sleep(0.1)
        assert first.poll() is None, first.communicate()
        os.kill(first.pid, signal.SIGINT)
        _, said = first.communicate(timeout=120)
        if first.returncode == 130:
            assert isinstance(read_journal(journal)[-1], Stopped)
            teardown = [event.text for event in open_run(out / "round_1" / "survey").events]
            assert "torque off" in teardown
        for _ in range(TRIES):
            done = subprocess.run([*words, "--resume"], capture_output=True, text=True, check=False)
            if done.returncode in (0, 1):
                break
        assert done.returncode == 0, (said, done.stderr)
    finally:
        antenna.terminate()
        antenna.communicate(timeout=60)
    answer = json.loads(done.stdout)
    assert answer["ending"] == "at_the_floor"
    assert [(e["name"], e["axis"]) for one in answer["rounds"] for e in one["effects"]] == [("cogging", "outer")]
    runs = [entry.run for entry in read_journal(journal) if isinstance(entry, Measured)]
    assert len(runs) == len(set(runs)) >= 3


@pytest.mark.heavy
def test_a_killed_improvement_leaves_no_daemon_that_goes_on(tmp_path: Path) -> None:
    config, out = configuration(tmp_path), tmp_path / "out"
    antenna = plant(tmp_path)
    words = improve(config, out)
    try:
        first = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while first.poll() is None and not (out / "round_1" / "survey" / "checkpoint.json").exists():
            time.sleep(0.1)
        assert first.poll() is None
        first.kill()
        first.wait()
        end = time.monotonic() + 60.0
        while (ended := open_run(out / "daemon_1").record.end) is None and time.monotonic() < end:
            time.sleep(0.2)
    finally:
        antenna.terminate()
        antenna.communicate(timeout=60)
    assert ended is not None and ended.exit_code == 130
    sent = columns_of(open_run(out / "daemon_1").frames, "set_point")
    assert all(
        sent.raw[f"enable_{axis}"][-1] == 0 and sent.raw[f"torque_{axis}"][-1] == 0 for axis in ("outer", "inner")
    )
