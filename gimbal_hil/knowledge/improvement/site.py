"""Where experiments are run: the virtual antenna in this process, or whatever answers on the link, through a daemon in
real time.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from firmware_protocol.errors import GimbalHilError, LinkError
from firmware_protocol.interpreter import apart_from_the_users_folder
from gimbal_hil.knowledge.experiments import (
    Experiment,
    ProgressSink,
    conduct,
    conduct_through_daemon,
    embedded_model_of,
)
from gimbal_hil.loop.host import HostState, word_of
from gimbal_hil.loop.settings import DaemonSettings, EmbeddedAntenna
from gimbal_hil.realtime.operator import OperatorClient, RequestRefusedError
from sim_backend.model import AntennaModel

#: a daemon may take so long until its door is open (it may have to compile first), and so long to end
_OPENING_S, _ENDING_S = 300.0, 20.0
_READY, _FAULT = (word_of(HostState.IDLE), word_of(HostState.ACTIVE)), word_of(HostState.FAULT)
#: the host may take so long until it is ready
_READY_S = 30.0


class Site(Protocol):
    """Runs experiments into run folders."""

    @property
    def text(self) -> str:
        """Where, for logs and reports."""

    def run(self, experiment: Experiment, folder: Path, number: int, progress: ProgressSink) -> None:
        """Run experiment number `number` of this improvement; what is in the folder is replaced."""


@dataclass(frozen=True)
class VirtualSite:
    """The virtual antenna that the configuration names, in lockstep. Its model is not looked at, only run."""

    settings: DaemonSettings
    antenna: AntennaModel
    seed: int

    @property
    def text(self) -> str:
        """Where."""
        return f"the virtual antenna of the configuration, in lockstep at {self.settings.rate_hz:g} Hz"

    def run(self, experiment: Experiment, folder: Path, number: int, progress: ProgressSink) -> None:
        """See Site; every run is another measurement, so its noise has another seed."""
        conduct(experiment, self.settings, self.antenna, self.seed + number, folder, force=True, progress=progress)


@dataclass(frozen=True)
class DaemonSite:
    """The antenna behind the daemon that records into `daemon_run`."""

    daemon_run: Path
    rate_hz: float

    @property
    def text(self) -> str:
        """Where."""
        return f"the antenna on the link, through the daemon of {self.daemon_run}, in real time at {self.rate_hz:g} Hz"

    def run(self, experiment: Experiment, folder: Path, number: int, progress: ProgressSink) -> None:
        """See Site."""
        conduct_through_daemon(experiment, self.daemon_run, folder, force=True, progress=progress)


@contextmanager
def site_of(
    settings: DaemonSettings, config: Path | None, out: Path, daemon_run: Path | None, resume: bool
) -> Iterator[Site]:
    """The place to run experiments at.

    With `daemon_run` through that daemon; with an embedded antenna in this process; else through a daemon of its own on
    the configuration's link, which records below `out` and is shut down in the end. Raises LinkError when no antenna
    answers.
    """
    if daemon_run is not None:
        _until_ready(daemon_run, resume)
        yield DaemonSite(daemon_run, settings.rate_hz)
    elif isinstance(settings.link, EmbeddedAntenna):
        antenna, seed = embedded_model_of(settings)
        yield VirtualSite(settings, antenna, seed)
    else:
        with _own_daemon(config, out) as run:
            _until_ready(run, resume)
            yield DaemonSite(run, settings.rate_hz)


@contextmanager
def _own_daemon(config: Path | None, out: Path) -> Iterator[Path]:
    number = 1 + sum(1 for _ in out.glob("daemon_*.log"))
    run, log = out / f"daemon_{number}", out / f"daemon_{number}.log"
    out.mkdir(parents=True, exist_ok=True)
    words = [
        sys.executable,
        "-c",
        "from gimbal_hil.surface.cli import main; main()",
        "daemon",
        "--config",
        str(config),
        "--out",
        str(run),
        # where this process is killed, the daemon switches torque off and ends as well
        "--end-with",
        str(os.getpid()),
        "--json",
    ]
    with log.open("wb") as said, apart_from_the_users_folder():
        # in a session of its own: Ctrl-C first brings the joints back, and only then ends the daemon
        process = subprocess.Popen(words, stdout=said, stderr=said, start_new_session=True)
    try:
        _until_open(process, run, log)
        yield run
    finally:
        _end(process, run)


def _until_open(process: subprocess.Popen[bytes], run: Path, log: Path) -> None:
    end = time.monotonic() + _OPENING_S
    while not (run / "operator.json").exists():
        if process.poll() is not None:
            lines = log.read_text(errors="replace").strip().splitlines()
            raise LinkError(
                f"the daemon ended at once: {lines[-1].removeprefix('error: ') if lines else 'without a message'}"
            )
        if time.monotonic() > end:
            raise LinkError(f"{run}: the daemon did not open its operator socket")
        time.sleep(0.05)


def _until_ready(run: Path, reset_faults: bool) -> None:
    """Wait for the host to be ready; who resumes has seen why it stopped, so a fault is reset then."""
    end = time.monotonic() + _OPENING_S
    ticking = False
    with OperatorClient(run, timeout_s=_OPENING_S) as client:
        while (state := (status := client.request("status")["status"])["host_state"]) not in _READY:
            if not ticking and status["tick"] > 0:
                # before its first tick a daemon may have to compile; after it the antenna has to answer
                ticking, end = True, time.monotonic() + _READY_S
            if state == _FAULT and reset_faults:
                client.request("fault_reset")
            if time.monotonic() > end:
                raise LinkError(f"{run}: no antenna is ready on the link; the host is {state}")
            time.sleep(0.1)


def _end(process: subprocess.Popen[bytes], run: Path) -> None:
    """Shut the daemon down: asked at its door, then by signal."""
    if process.poll() is None:
        try:
            with OperatorClient(run, timeout_s=5.0) as client:
                client.request("shut_down")
        except (GimbalHilError, RequestRefusedError):
            process.terminate()
    try:
        process.wait(_ENDING_S)
    except subprocess.TimeoutExpired:
        process.terminate()
        try:
            process.wait(_ENDING_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
