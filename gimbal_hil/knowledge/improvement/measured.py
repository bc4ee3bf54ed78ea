"""The measurement of an experiment's run as one signals table: from its first step until the return motion begins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import EventKind, RecordedRun, open_run
from gimbal_hil.data.signals import SignalsTable, signals_of_run


def measured_table(folder: Path, axes: Sequence[str]) -> SignalsTable:
    """Signals of a run under control: without the fall before it and the way back after it; frames lost on a link are
    made up.

    Raises BadInputError where the run holds no step.
    """
    run = open_run(folder)
    steps = [event for event in run.events if event.kind is EventKind.SEGMENT]
    if not steps:
        raise BadInputError(str(folder), "has no measured step", "the run of an experiment")
    back = next((event.tick for event in steps if event.begins_teardown), None)
    part = _between(run, steps[0].tick, back)
    return signals_of_run(part, axes, resample=True, drop_invalid=True)


def _between(run: RecordedRun, first: int, last: int | None) -> RecordedRun:
    """The rows from one tick up to another."""
    end = np.inf if last is None else last
    ticks, frames = run.ticks["tick"], run.frames["tick"]
    return replace(
        run, ticks=run.ticks[(ticks >= first) & (ticks < end)], frames=run.frames[(frames >= first) & (frames < end)]
    )
