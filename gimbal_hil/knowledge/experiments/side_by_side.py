"""Parts of an experiment on virtual antennas side by side, one process each, and their logs as one run folder.

A part is an experiment of its own with its own log and checkpoints below `parts/`, so what it measures does not depend
on how many processes there are. When all parts are done their logs are put one after the other into the run folder, and
`parts/` goes. A run that was stopped or killed at any point goes on from the checkpoints of its parts; one that was
complete only takes its way back again.
"""

from __future__ import annotations

import fcntl
import os
import pickle
import shutil
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING

from firmware_protocol.errors import EXIT_INTERRUPTED, BadInputError
from firmware_protocol.interpreter import apart_from_the_users_folder
from firmware_protocol.json_object import Json
from gimbal_hil.data.runs import EventKind, RunHeader, RunWriter, open_run
from gimbal_hil.knowledge.experiments.antenna import AntennaUnderTest
from gimbal_hil.knowledge.experiments.checkpoint import CHECKPOINT_FILE, read_checkpoint
from gimbal_hil.knowledge.experiments.experiment import Experiment, Row, Signals
from gimbal_hil.knowledge.experiments.runner import Outcome, ProgressSink, Silent, run_experiment
from gimbal_hil.knowledge.experiments.step_signals import STEPS_FOLDER, step_file

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.context import SpawnProcess
    from multiprocessing.sharedctypes import Synchronized
    from multiprocessing.synchronize import Event as Flag

PARTS_FOLDER = "parts"
#: whose turn a part is; the lock of its run, which refuses and does not wait, is taken within
_TURN_FILE = ".turn"
_LOOK_S = 0.2


@dataclass(frozen=True)
class _Part:
    """One part: what is run, on what, where; picklable."""

    experiment: Experiment
    antenna: Callable[[], AntennaUnderTest]
    folder: Path
    header: RunHeader

    def run(self, progress: ProgressSink) -> None:
        """From its last checkpoint, or from the start; waits until no other process is at it."""
        with _alone(self.folder), closing(self.antenna()) as antenna:
            resume = (self.folder / CHECKPOINT_FILE).exists()
            run_experiment(
                self.experiment, antenna, self.folder, self.header, resume=resume, force=True, progress=progress
            )


def run_side_by_side(
    experiment: Experiment,
    antenna: Callable[[], AntennaUnderTest],
    folder: Path,
    header: RunHeader,
    *,
    resume: bool = False,
    force: bool = False,
    progress: ProgressSink | None = None,
) -> Outcome:
    """Run the parts of an experiment, each on an antenna of its own (`antenna()`, picklable), and leave one run folder.

    Like `run_experiment` otherwise. The processes end with this one, however it ends.
    """
    parts_folder = folder / PARTS_FOLDER
    if resume and not parts_folder.is_dir():
        raise BadInputError(str(parts_folder), "no such folder", "the folder of an experiment that was stopped")
    with RunWriter(folder, header, force=force or resume) as writer:
        if not resume:
            for old in (parts_folder, folder / STEPS_FOLDER):
                shutil.rmtree(old, ignore_errors=True)
        parts = [
            _Part(part, antenna, parts_folder / f"{number}", header) for number, part in enumerate(experiment.parts)
        ]
        sink = progress or Silent()
        sink.begin(
            experiment.name,
            sum(step.segment.duration_ticks for step in experiment.steps) * header.period_ns * 1e-9,
            0.0,
        )
        _run_all(parts, sink)
        return _as_one(experiment, parts, writer)


def remove_parts(folder: Path) -> None:
    """Take the parts away once the results of all of them are written."""
    shutil.rmtree(folder / PARTS_FOLDER, ignore_errors=True)


def _run_all(parts: Sequence[_Part], sink: ProgressSink) -> None:
    """The last part in this process, the others in one each."""
    context = get_context("spawn")
    with apart_from_the_users_folder():  # the first lock starts the tracker
        done_s, stop = context.Value("d", 0.0), context.Event()
    others: list[tuple[SpawnProcess, Connection]] = []
    try:
        for part in parts[:-1]:
            near, far = context.Pipe(duplex=False)
            process = context.Process(target=_in_own_process, args=(part, done_s, stop, far, os.getpid()), daemon=True)
            with apart_from_the_users_folder():
                process.start()
            far.close()
            others.append((process, near))
        here = _WithOthers(sink, done_s)
        parts[-1].run(here)
        for process, near in others:
            while process.is_alive() and not near.poll(_LOOK_S):
                here.look()
            _raise_of(process, near)
    finally:
        stop.set()
        for process, _ in others:
            process.join()


def _in_own_process(part: _Part, done_s: Synchronized[float], stop: Flag, answer: Connection, parent: int) -> None:
    # Ctrl-C reaches every process of a terminal: the parent decides, so that the way back comes once and in order
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    failure: BaseException | None = None
    try:
        part.run(_Telling(done_s, stop, parent))
    except BaseException as error:
        failure = error
    try:
        answer.send(failure)
    except (pickle.PicklingError, TypeError, AttributeError):
        answer.send(RuntimeError(f"{type(failure).__name__}: {failure}"))


def _raise_of(process: SpawnProcess, near: Connection) -> None:
    try:
        failure = (
            near.recv()
            if near.poll()
            else RuntimeError(f"a part of the experiment ended with exit status {process.exitcode}")
        )
    except EOFError:
        failure = RuntimeError("a part of the experiment ended without an answer")
    if failure is not None:
        raise failure


class _Telling(Silent):
    """Progress of a part in a process of its own: told to the parent, ended by it and with it."""

    def __init__(self, done_s: Synchronized[float], stop: Flag, parent: int) -> None:
        self._done_s, self._stop, self._parent = done_s, stop, parent

    def begin(self, text: str, total_s: float, done_s: float) -> None:
        """See ProgressSink."""
        self._add(done_s)

    def at(self, step: str, advanced_s: float) -> None:
        """See ProgressSink."""
        self._add(advanced_s)
        if os.getppid() != self._parent:
            # nobody waits for this any more, and whoever goes on with the run must not find a second writer
            os._exit(EXIT_INTERRUPTED)
        if self._stop.is_set():
            raise KeyboardInterrupt

    def _add(self, seconds: float) -> None:
        with self._done_s.get_lock():
            self._done_s.value += seconds


class _WithOthers(Silent):
    """Progress of the part in this process, with that of the others added."""

    def __init__(self, sink: ProgressSink, done_s: Synchronized[float]) -> None:
        self._sink, self._done_s, self._told_s, self._step = sink, done_s, 0.0, ""

    def begin(self, text: str, total_s: float, done_s: float) -> None:
        """See ProgressSink."""
        self.at("", done_s)

    def at(self, step: str, advanced_s: float) -> None:
        """See ProgressSink."""
        others_s, self._step = self._done_s.value, step
        self._sink.at(step, advanced_s + others_s - self._told_s)
        self._told_s = others_s

    def look(self) -> None:
        """Tell of the others alone."""
        self.at(self._step, 0.0)


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Wait for a turn at a part: the process of a killed parent may still be at its last step.

    The turn ends with the process that has it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / _TURN_FILE).open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _as_one(experiment: Experiment, parts: Sequence[_Part], writer: RunWriter) -> Outcome:
    """Logs one after the other with ticks that go on, steps' tables numbered through, rows and drawn signals
    together.
    """
    rows: list[Row] = []
    drawn: dict[str, Signals] = {}
    tick, steps = 0, 0
    period_ns = parts[0].header.period_ns
    for number, part in enumerate(parts):
        run, checkpoint = open_run(part.folder), read_checkpoint(part.folder)
        writer.event(
            tick, 0, EventKind.NOTE, f"part {number + 1} of {len(parts)}: an antenna of its own, ticks from {tick} on"
        )
        for event in run.events:
            data: Json = dict(event.data)
            if event.kind is EventKind.SEGMENT and "number" in data:
                data["number"] += steps
            time_ns = event.time_ns + tick * period_ns if event.time_ns else 0
            writer.event(event.tick + tick, time_ns, event.kind, event.text, data)
        ticks = run.ticks.copy()
        ticks["tick"] += tick
        ticks["time_ns"] += tick * period_ns
        writer.append_ticks(ticks)
        for place in range(len(part.experiment.steps)):
            target = step_file(writer.folder, steps + place)
            target.parent.mkdir(exist_ok=True)
            with suppress(FileNotFoundError):
                # a link costs nothing, and the part stays whole until all is done
                target.unlink(missing_ok=True)
                os.link(step_file(part.folder, place), target)
        rows += checkpoint.rows
        drawn |= checkpoint.drawn
        steps += len(part.experiment.steps)
        tick = int(ticks["tick"][-1]) + experiment.every
    return Outcome(experiment, tuple(rows), drawn, writer.folder)
