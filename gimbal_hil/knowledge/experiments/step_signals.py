"""Signals of long steps: an experiment whose log is thinned out leaves a signals table for each of its measured steps.

Frames of a whole sliding sequence would fill a disk, and its log rows hold no measurement. So each measured step of a
thinned experiment has a table of its own, `steps/<number>.npz`, at the constant rate that the step asked for: input
of identification and of anyone else. So has each measured step on a real antenna, whose log has gaps where a sequence
was stopped and resumed.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gimbal_hil.knowledge.experiments.experiment import Signals, axes_of

STEPS_FOLDER = "steps"


def step_file(folder: Path, number: int) -> Path:
    """Where the signals of step `number` of the experiment in a folder are kept."""
    return folder / STEPS_FOLDER / f"{number:04d}.npz"


def write_step_signals(folder: Path, number: int, signals: Signals) -> Path:
    """Keep the signals of step `number`; columns that hold nothing (references of open loops, a base at rest) are left
    out.
    """
    from gimbal_hil.data.signals import SignalsTable, column_names, write_signals

    axes = axes_of(signals)
    known = column_names(axes)
    columns = {
        name: values
        for name, values in signals.items()
        if name in known and name != "time_s" and np.all(np.isfinite(values))
    }
    if not any(np.any(values) for name, values in columns.items() if name.startswith("base.")):
        columns = {name: values for name, values in columns.items() if not name.startswith("base.")}
    path = step_file(folder, number)
    path.parent.mkdir(exist_ok=True)
    table = SignalsTable.of(axes, signals["time_s"], columns)
    write_signals(table, path, force=True)
    return path
