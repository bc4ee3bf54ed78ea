"""Runs an experiment on an antenna into a run folder: guards on entry, a checkpoint after every step, a teardown that
always comes.

The runner does not depend on links and clocks: an `AntennaUnderTest` follows steps, whether it is the virtual one in
lockstep or a real one behind the daemon.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Protocol

import numpy as np

from firmware_protocol.errors import BadInputError, GimbalHilError, SafetyStopError
from gimbal_hil.data.runs import EventKind, RunHeader, RunWriter, StepPurpose
from gimbal_hil.knowledge.experiments.antenna import AntennaUnderTest, Followed
from gimbal_hil.knowledge.experiments.checkpoint import Checkpoint, read_checkpoint, remove_checkpoint, write_checkpoint
from gimbal_hil.knowledge.experiments.experiment import Experiment, Row, Signals, Step, move_to
from gimbal_hil.knowledge.experiments.step_signals import STEPS_FOLDER, write_step_signals
from gimbal_hil.loop.host import EventCode, Segment, word_of
from gimbal_hil.pages.report import Block

#: the way back to the safe pose may take so long
TEARDOWN_S = 10.0


class ProgressSink(Protocol):
    """What shows progress: told of simulated or real time done."""

    def begin(self, text: str, total_s: float, done_s: float) -> None:
        """An experiment of `total_s` seconds starts, `done_s` of them already behind it."""

    def at(self, step: str, advanced_s: float) -> None:
        """So much more is done; this step is being followed."""


class Silent:
    """Shows nothing."""

    def begin(self, text: str, total_s: float, done_s: float) -> None:
        """See ProgressSink."""

    def at(self, step: str, advanced_s: float) -> None:
        """See ProgressSink."""


@dataclass(frozen=True)
class Outcome:
    """What an experiment left: its table, the signals that its report draws, and where the log is."""

    experiment: Experiment
    rows: tuple[Row, ...]
    drawn: Mapping[str, Signals]
    folder: Path

    @cached_property
    def blocks(self) -> list[Block]:
        """What its report says; the experiment's own page and others show it."""
        return self.experiment.conclude(self.rows, self.drawn)


def plan_hash(experiment: Experiment) -> str:
    """Hash over everything that the steps ask of the antenna: a checkpoint belongs to one plan."""
    digest = hashlib.sha256(experiment.name.encode())
    for step in experiment.steps:
        digest.update(step.name.encode())
        digest.update(step.program.values.tobytes())
        digest.update(json.dumps([dict(step.meaning), step.every], sort_keys=True).encode())
    return digest.hexdigest()


def run_experiment(
    experiment: Experiment,
    antenna: AntennaUnderTest,
    folder: Path,
    header: RunHeader,
    *,
    resume: bool = False,
    force: bool = False,
    progress: ProgressSink | None = None,
) -> Outcome:
    """Run all steps (with `resume`, those that the checkpoint in `folder` leaves); the log is closed and torque off
    however it ends.

    The checkpoint stays, also after the last step: whoever writes the results takes it away (`remove_checkpoint`).
    """
    progress = progress or Silent()
    digest = plan_hash(experiment)
    if resume:
        start = read_checkpoint(folder)
        if start.plan_hash != digest:
            raise BadInputError(
                str(folder), "was made by another plan or configuration", "the same experiment with the same options"
            )
        writer = RunWriter.resumed(folder, header, start.log_mark)
        if start.state is not None:
            antenna.put_back(dict(start.state))
    else:
        start = Checkpoint(0, digest, (), {}, None, {})
        writer = RunWriter(folder, header, force=force)
        remove_checkpoint(folder)
        shutil.rmtree(folder / STEPS_FOLDER, ignore_errors=True)
    with writer:
        session = _Session(experiment, antenna, writer, progress, digest)
        return session.run(start)


class _Session:
    """One run of the runner: the log, the table and the checkpoints of one experiment."""

    def __init__(
        self, experiment: Experiment, antenna: AntennaUnderTest, writer: RunWriter, progress: ProgressSink, digest: str
    ) -> None:
        self.experiment, self.antenna, self.writer, self.progress, self.digest = (
            experiment,
            antenna,
            writer,
            progress,
            digest,
        )
        #: tick at which the last step was asked for
        self._asked = 0

    def run(self, start: Checkpoint) -> Outcome:
        """All steps from a checkpoint on, then the teardown."""
        rate = self.antenna.rate_hz
        steps = self.experiment.steps
        done_s = sum(step.segment.duration_ticks for step in steps[: start.done]) / rate
        self.progress.begin(self.experiment.name, self.experiment.duration_s(rate), done_s)
        rows, drawn = list(start.rows), dict(start.drawn)
        if start.state is None:
            self._log(self.antenna.connect())
        try:
            for number in range(start.done, len(steps)):
                step = steps[number]
                followed = self._follow(number, step)
                state = self.antenna.keep()
                if step.measured and (self.experiment.every > 1 or state is None):
                    # the log is thinned, or that of a real antenna, with gaps where a sequence was stopped
                    write_step_signals(self.writer.folder, number, followed.signals)
                if step.measured:
                    row = self.experiment.measure(step, followed.signals)
                    if row is not None:
                        rows.append({"step": step.name, **dict(step.meaning), **row})
                if step.name in self.experiment.drawn:
                    drawn[step.name] = followed.signals
                mark = self.writer.mark()
                self.writer.require_room()
                write_checkpoint(
                    self.writer.folder, Checkpoint(number + 1, self.digest, tuple(rows), mark, state, drawn)
                )
        except BaseException:
            # an error during the way back must not hide why it was needed
            try:
                self._tear_down()
            except GimbalHilError as error:
                # the antenna may be gone
                self.writer.event(self._asked, 0, EventKind.NOTE, f"teardown: {error}")
            raise
        self._tear_down()
        return Outcome(self.experiment, tuple(rows), drawn, self.writer.folder)

    def _follow(self, number: int, step: Step) -> Followed:
        check_guards(step, self.antenna)
        data = {"step": step.name, "number": number, "purpose": StepPurpose.MEASUREMENT, **dict(step.meaning)}
        return self._made(step, data, lambda ticks: self.progress.at(step.name, ticks / self.antenna.rate_hz))

    def _made(self, step: Step, data: Mapping[str, object], progress: Callable[[int], None]) -> Followed:
        """Follow a step and keep it; its event says the tick at which it began, not the one at which it was asked."""
        self._asked = self.antenna.tick
        try:
            followed = self.antenna.follow(step, progress)
        except BaseException:
            self.writer.event(self._asked, 0, EventKind.SEGMENT, step.name, data)
            raise
        self.writer.event(followed.first_tick, 0, EventKind.SEGMENT, step.name, data)
        self._log(followed)
        return followed

    def _log(self, followed: Followed) -> None:
        writer = self.writer
        if followed.program is not None:
            start = {"command": "start", "program": followed.program.as_document()}
            writer.command(
                followed.first_tick, int(followed.rows["time_ns"][0]) if len(followed.rows) else 0, "start", start
            )
        for told in followed.logged:
            writer.event(told.tick, told.time_ns, told.kind, told.text, told.data)
        for event in followed.events:
            kind = EventKind.STATE if event.code is EventCode.STATE else EventKind.NOTE
            data = {"code": word_of(event.code), **event.data} if event.code is EventCode.POINTING else {}
            writer.event(event.tick, 0, kind, event.text, data)
        if self.experiment.every == 1:
            writer.append_frames(followed.frames)
            writer.append_ticks(followed.rows)
        else:
            writer.append_ticks(followed.rows[followed.rows["tick"] % self.experiment.every == 0])

    def _tear_down(self) -> None:
        """Back to the middle of the travel, then torque off; limited in time, and skipped where the host has already
        stopped.
        """
        rate = self.antenna.rate_hz
        back = Segment(duration_ticks=round(0.8 * TEARDOWN_S * rate), outer=move_to(0.0, 5.0), inner=move_to(0.0, 5.0))
        off = Segment(
            duration_ticks=round(0.1 * rate),
            switch_off_afterwards=True,
            outer=move_to(0.0, 0.05),
            inner=move_to(0.0, 0.05),
        )
        for step in (Step("back to the safe pose", back), Step("torque off", off)):
            self._made(step, {"step": step.name, "purpose": StepPurpose.TEARDOWN}, lambda ticks: None)


def check_guards(step: Step, antenna: AntennaUnderTest) -> None:
    """Refuse to enter a step whose guards the antenna already violates; SafetyStopError names step, axis and value."""
    for axis, command in zip(antenna.axes, (step.segment.outer, step.segment.inner), strict=True):
        position = antenna.position_rad(axis)
        guard = command.guard
        if not guard.low_rad <= position <= guard.high_rad:
            raise SafetyStopError(
                f"step {step.name!r}: {axis} stands at {position:.4f} rad; its guard allows {guard.low_rad:g} to "
                f"{guard.high_rad:g} rad"
            )


def table_csv(rows: Sequence[Row]) -> str:
    """The table of an experiment as CSV: one row a measured step, columns in order of first appearance."""
    names: list[str] = []
    for row in rows:
        names += [name for name in row if name not in names]
    lines = [",".join(names)]
    lines += [",".join(_cell(row.get(name)) for name in names) for row in rows]
    return "\n".join(lines) + "\n"


def _cell(value: object) -> str:
    if value is None:
        return ""
    text = repr(float(value)) if isinstance(value, float | np.floating) else str(value)
    return f'"{text}"' if "," in text else text
