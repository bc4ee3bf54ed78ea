"""Signals of long steps: an experiment whose log is thinned out leaves a signals table for each of its measured steps.

Frames of a whole sliding sequence would fill a disk, and its log rows hold no measurement. So each measured step of a thinned experiment
has a table of its own, `steps/<number>.parquet`, at the constant rate that the step asked for: input of identification and of anyone else.
So has each measured step on a real antenna, whose log has gaps where a sequence was stopped and gone on with.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gimbal_hil.experiments.experiment import AXES, Signals

STEPS_FOLDER = "steps"


def write_step_signals(folder: Path, number: int, signals: Signals, tick_s: float) -> Path:
    """Keep the signals of step `number`; columns that hold nothing (references of open loops) are left out.

    In a signals table the torque of row k acts over [t_k, t_k+1). Where rows were left out that is the mean of the torques sampled at both
    ends: the sample at t_k alone would be half a row late, which on a slope of gravity looks like friction.
    """
    from gimbal_hil.signals import SignalsTable, column_names, write_signals

    known = column_names(AXES)
    columns = {name: values for name, values in signals.items() if name in known and name != "time_s" and np.all(np.isfinite(values))}
    if signals["time_s"][1] - signals["time_s"][0] > 1.5 * tick_s:
        for name in (f"{axis}.torque" for axis in AXES):
            torque = columns[name]
            columns[name] = np.append(0.5 * (torque[1:] + torque[:-1]), torque[-1])
    path = folder / STEPS_FOLDER / f"{number:04d}.parquet"
    path.parent.mkdir(exist_ok=True)
    table = SignalsTable.of(AXES, signals["time_s"], columns)
    write_signals(table, path, force=True)
    return path
