"""Daemon and antenna in lockstep in two processes: the run folder of an antenna in the daemon's own process."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from firmware_protocol.errors import BadInputError
from firmware_protocol.links import AdapterLinkConfig, FaultsConfig, UnixLinkConfig
from gimbal_hil.data.runs import EventKind, RecordedRun, open_run
from gimbal_hil.realtime.daemon.first_opening import PortConfig
from gimbal_hil.realtime.daemon.lockstep_link import open_in_lockstep
from tests.daemon.daemons import RunningDaemon, patient_configuration

pytestmark = pytest.mark.realtime
DRIVE = {"id": 1, "torque_nm": 1.0}
DRIVES = {"kind": "adapter", "drive": "moteus", "interface": "unix", "channel": "x", "drives": [DRIVE, DRIVE]}
#: so long that a cold compile fits
PATIENCE = ("--answer-within", "300")


@contextmanager
def plant(link: str, folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    words = ["plant", "--link", link, "--lockstep", "--seed", "1", "--ready-file", str(folder / "ready"), "--json"]
    program = f"from gimbal_hil.surface.cli.app import main; main({words!r})"
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as served:
        try:
            while not (folder / "ready").exists():
                assert served.poll() is None, "the plant ended"
                time.sleep(0.05)
            yield served
        finally:
            served.send_signal(signal.SIGCONT)
            served.terminate()


def recorded(folder: Path, link: dict[str, object] | None, *words: str) -> RecordedRun:
    # the first test gives every run a motion
    configuration = patient_configuration(folder, link, first_test="always")
    run = folder / ("own" if link is None else str(link["kind"]))
    with RunningDaemon(run, "--config", str(configuration), "--lockstep", "--duration", "1.5", *words) as daemon:
        code, answer, said = daemon.wait()
    assert code == 0, (answer, said)
    return open_run(run)


@pytest.mark.heavy
@pytest.mark.parametrize("kind", ["unix", pytest.param("serial", marks=pytest.mark.heavy)])
def test_both_processes_leave_the_run_folder_of_one(kind: str, tmp_path: Path) -> None:
    place = tmp_path / "antenna"
    link: dict[str, object] = {"kind": kind, ("path" if kind == "unix" else "port"): str(place)}
    with plant(f"{kind}:{place}", tmp_path):
        apart = recorded(tmp_path, link, *PATIENCE)
    together = recorded(tmp_path, None)
    assert len(apart.ticks) > 1500 and abs(apart.ticks["torque_outer"]).max() > 0.0
    assert apart.ticks.tobytes() == together.ticks.tobytes()
    assert apart.frames.tobytes() == together.frames.tobytes()
    assert apart.event_lines == together.event_lines
    assert apart.content_hashes() == together.content_hashes()


@contextmanager
def daemon_whose_antenna_hangs(tmp_path: Path, patience_s: int) -> Iterator[RunningDaemon]:
    """A daemon in lockstep, its run in `tmp_path / "run"`, whose antenna has just stopped to answer."""
    place = tmp_path / "antenna"
    configuration = patient_configuration(tmp_path, {"kind": "unix", "path": str(place)})
    words = ("--config", str(configuration), "--lockstep", "--answer-within", str(patience_s))
    with plant(f"unix:{place}", tmp_path) as served, RunningDaemon(tmp_path / "run", *words) as daemon:
        daemon.until_state(daemon.client(), "idle")
        os.kill(served.pid, signal.SIGSTOP)
        yield daemon


@pytest.mark.heavy
def test_an_antenna_that_hangs_ends_the_run_with_a_safety_stop_that_says_so(tmp_path: Path) -> None:
    with daemon_whose_antenna_hangs(tmp_path, 2) as daemon:
        code, answer, said = daemon.wait()
    assert code == 3 and "no answer to tick" in answer["reason"], (answer, said)
    notes = [event.text for event in open_run(tmp_path / "run").events if event.kind is EventKind.NOTE]
    assert any("no answer to tick" in text for text in notes)


@pytest.mark.heavy
def test_ctrl_c_ends_a_daemon_whose_antenna_hangs(tmp_path: Path) -> None:
    with daemon_whose_antenna_hangs(tmp_path, 0) as daemon:
        time.sleep(0.5)
        daemon.process.send_signal(signal.SIGINT)
        code, answer, _ = daemon.wait()
    assert code == 130, answer


@pytest.mark.parametrize(
    ("config", "said"),
    [
        (UnixLinkConfig(kind="unix", path=Path("x"), faults=FaultsConfig()), "link.faults"),
        (AdapterLinkConfig.model_validate(DRIVES), "clocks of their own"),
    ],
)
def test_what_cannot_be_in_lockstep_is_refused(config: PortConfig, said: str) -> None:
    with pytest.raises(BadInputError, match=said):
        open_in_lockstep(config, 0.1)
