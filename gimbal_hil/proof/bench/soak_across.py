"""`gimbal-hil bench soak --link ...`: an hour of plant and daemon as two processes in real time, random commands, one
frame in a hundred lost, doubled, damaged or late; whether every tick is accounted for and memory stays as it is.
"""

from __future__ import annotations

import json
import os
import random
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import GimbalHilError, LinkError
from firmware_protocol.json_object import Json
from gimbal_hil.data.runs import GrowingLog, open_run
from gimbal_hil.loop.host import EventCode, HostState, word_of
from gimbal_hil.loop.settings import load_settings
from gimbal_hil.proof.bench.soak import FAULTS, MEMORY_SHARE, WRONG, random_program, torque_problems
from gimbal_hil.proof.bench.two_processes import begun, running_plant, two_process_configuration
from gimbal_hil.realtime.operator import OperatorClient, RequestRefusedError

#: memory is looked at and the log read this often; memory counts after this share of the time
_LOOK_S, _WARM_SHARE = 20.0, 1.0 / 6.0
_START_S, RATE_HZ = 300.0, 1000.0
_MB = 1 << 20


@dataclass
class AcrossFigures:
    """What was seen; `problems` is empty when all was right."""

    link: str
    wall_s: float = 0.0
    #: rows of the log as they came, and periods that they say were skipped
    rows: int = 0
    skipped: int = 0
    last_tick: int = -1
    commands: dict[str, int] = field(default_factory=dict)
    refused: int = 0
    faults_of_host: dict[str, int] = field(default_factory=dict)
    #: resident memory of each process, MiB, at each look
    memory_mb: dict[str, list[float]] = field(default_factory=dict)
    #: what the daemon and the plant answered in the end
    daemon: Json = field(default_factory=dict)
    plant: Json = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)

    def memory_gained(self, process: str) -> float:
        """Share of memory that the last look has more than the first one after warming up."""
        seen = self.memory_mb[process]
        return seen[-1] / seen[int(len(seen) * _WARM_SHARE)] - 1.0

    def count(self, rows: NDArray[np.void], limits_nm: list[float]) -> None:
        """Take rows that follow those before; every period is a row or was skipped by the next one."""
        if not len(rows):
            return
        numbers = np.concatenate([[self.last_tick], rows["tick"]])
        missing = np.diff(numbers) - 1 - rows["skipped_ticks"]
        if missing.any():
            self.problems.append(f"ticks unaccounted for near {int(rows['tick'][np.argmax(missing != 0)])}")
        self.rows += len(rows)
        self.skipped += int(rows["skipped_ticks"].sum())
        self.last_tick = int(rows["tick"][-1])
        self.problems += [f"{problem}, before tick {self.last_tick}" for problem in torque_problems(rows, limits_nm)]


def soak_across(link: str, hours: float, seed: int, say: Callable[[str], None]) -> AcrossFigures:
    """Run for `hours` of real time on one link; the log keeps its newest 256 MiB and is read as it grows."""
    figures = AcrossFigures(link)
    hurt = dict.fromkeys(("drop", "duplicate", "corrupt", "delay"), FAULTS / 4.0)
    with tempfile.TemporaryDirectory(prefix="gimbal-hil-") as name:
        folder = Path(name)
        configuration = two_process_configuration(
            folder,
            link,
            RATE_HZ,
            {
                "link": {"faults": {"seed": seed, "send": hurt, "receive": hurt}},
                "recording": {"segment_mb": 32.0, "keep_mb": 256.0},
            },
        )
        limits = [axis.limits.torque_nm for axis in load_settings(configuration).axes.values()]
        with running_plant(configuration) as plant, _running_daemon(configuration, folder / "run", figures) as daemon:
            with OperatorClient(folder / "run", timeout_s=30.0) as operator:
                soak = _Soak(operator, folder / "run", limits, figures, random.Random(seed), say)
                soak.go_on({"daemon": daemon.pid, "plant": plant.pid}, hours)
                operator.request("shut_down")
            figures.daemon = json.loads(daemon.communicate(timeout=60.0)[0])
        figures.plant = plant.served
        _close(folder / "run", figures, limits)
    return figures


@contextmanager
def _running_daemon(configuration: Path, run: Path, figures: AcrossFigures) -> Iterator[subprocess.Popen[str]]:
    """`gimbal-hil daemon` with its door open; where it has gone too early, that is a problem with its last words."""
    words = ["daemon", "--config", str(configuration), "--out", str(run), "--page", "0", "--json"]
    with (run.parent / "daemon.err").open("w+") as said:
        daemon = begun(words, said)
        try:
            began = time.monotonic()
            while not (run / "operator.json").exists():
                if daemon.poll() is not None or time.monotonic() - began > _START_S:
                    raise GimbalHilError((run.parent / "daemon.err").read_text().strip() or "the daemon did not start")
                time.sleep(0.01)
            yield daemon
        except LinkError as error:
            figures.problems.append(f"{error}: {(run.parent / 'daemon.err').read_text().strip()[-400:]}")
        finally:
            if daemon.poll() is None:
                daemon.kill()
                daemon.wait()


@dataclass
class _Soak:
    operator: OperatorClient
    run: Path
    limits_nm: list[float]
    figures: AcrossFigures
    draw: random.Random
    say: Callable[[str], None]

    def go_on(self, pids: dict[str, int], hours: float) -> None:
        """Random commands until the time is over; log and memory looked at as it goes."""
        log, began = GrowingLog(self.run), time.monotonic()
        pids = pids | _children(pids["daemon"])
        look_at = ask_at = began
        while (now := time.monotonic()) - began < hours * 3600.0:
            if now >= ask_at:
                ask_at = now + self.draw.expovariate(0.5)
                self._ask()
            if now >= look_at:
                look_at = now + _LOOK_S
                self._look(log, pids)
            event = self.operator.next_event(max(0.001, min(ask_at, look_at) - time.monotonic()))
            data = event.get("data", {}) if event is not None else {}
            if data.get("code") == word_of(EventCode.STATE) and data["to"] == word_of(HostState.FAULT):
                cause = str(data["cause"])
                self.figures.faults_of_host[cause] = self.figures.faults_of_host.get(cause, 0) + 1
        self.figures.wall_s = time.monotonic() - began

    def _look(self, log: GrowingLog, pids: dict[str, int]) -> None:
        figures = self.figures
        figures.count(log.look(figures.last_tick + 1).ticks, self.limits_nm)
        for name, pid in pids.items():
            figures.memory_mb.setdefault(name, []).append(_memory_mb(pid))
        memory = ", ".join(f"{name} {seen[-1]:.1f}" for name, seen in figures.memory_mb.items())
        self.say(f"{figures.rows} rows, {figures.skipped} skipped; MiB: {memory}")

    def _ask(self) -> None:
        if self.operator.request("status")["status"]["host_state"] == word_of(HostState.FAULT):
            name = "fault_reset"
        else:
            name = self.draw.choices(("start", "stop", "quick_stop"), (0.85, 0.1, 0.05))[0]
        fields = {"program": random_program(self.draw, RATE_HZ).as_document()} if name == "start" else {}
        self.figures.commands[name] = self.figures.commands.get(name, 0) + 1
        try:
            self.operator.request(name, **fields)
        except RequestRefusedError:
            # not ready, or a fault came between status and start
            self.figures.refused += 1


def _close(run: Path, figures: AcrossFigures, limits_nm: list[float]) -> None:
    """What is left of the log, and the account: rows as read, as recorded, as run."""
    finished = open_run(run)
    figures.count(finished.ticks[finished.ticks["tick"] > figures.last_tick], limits_nm)
    end = finished.record.end
    recorded, told = end.counts["ticks"] if end else 0, figures.daemon.get("ticks", {})
    ran, missed = told.get("ticks", 0), told.get("missed", 0)
    if not figures.rows == recorded == ran or figures.skipped != missed or ran + missed != figures.last_tick + 1:
        figures.problems.append(
            f"{ran} ticks run and {missed} missed up to tick {figures.last_tick}, {figures.rows} rows of which"
            f" {figures.skipped} skipped, {recorded} recorded"
        )
    if figures.daemon.get("exit_code") != 0:
        figures.problems.append(f"the daemon ended: {figures.daemon.get('reason', 'without an answer')}")
    for process in figures.memory_mb:
        if abs(figures.memory_gained(process)) > MEMORY_SHARE:
            figures.problems.append(f"memory of {process} changed by {figures.memory_gained(process):.1%}")


def across_text(figures: AcrossFigures) -> str:
    """For people."""
    told = figures.daemon.get("ticks", {})
    causes = ", ".join(f"{count} {cause}" for cause, count in told.get("missed_by_cause", {}).items() if count)
    memory = ", ".join(
        f"{name} {seen[int(len(seen) * _WARM_SHARE)]:.1f} MiB, then {seen[-1]:.1f} ({figures.memory_gained(name):+.2%})"
        for name, seen in figures.memory_mb.items()
    )
    frames = ", ".join(f"{count} {what}" for what, count in figures.daemon.get("frames", {}).items())
    lines = [
        f"{figures.link}, {figures.wall_s:.0f} s: {told.get('ticks', 0)} ticks run, {told.get('missed', 0)} missed"
        f" ({causes or 'none'}), {figures.rows} rows in the log",
        f"asked: {_counted(figures.commands)}, {figures.refused} refused; faults: {_counted(figures.faults_of_host)}",
        f"frames of the host: {frames}; bad frames of the plant: {figures.plant.get('bad_frames', 0)}",
        f"memory after a sixth of the time and in the end: {memory}",
    ]
    return "\n".join([*lines, *(f"{WRONG}{problem}" for problem in figures.problems)])


def _counted(counts: dict[str, int]) -> str:
    return ", ".join(f"{count} {name}" for name, count in sorted(counts.items())) or "none"


def _children(pid: int) -> dict[str, int]:
    """The daemon's own processes, by what they are."""
    found: dict[str, int] = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            if int(path.read_text().rsplit(")", 1)[1].split()[1]) == pid:
                words = (path.parent / "cmdline").read_bytes()
                found["service" if b"gimbal_hil.realtime.service" in words else "witness"] = int(path.parent.name)
    return found


def _memory_mb(pid: int) -> float:
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / _MB
