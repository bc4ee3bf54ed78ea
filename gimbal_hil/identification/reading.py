"""Opens run folders and signals tables as logs, cut into stretches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from gimbal_hil.identification.evidence import Log
from gimbal_hil.identification.segments import Drive, Stretch, stretches_of_run, stretches_of_table
from gimbal_hil.runs import is_run_folder, open_run
from gimbal_hil.signals import SignalsTable, read_signals, signals_of_run


def read_log(path: Path, axes: Sequence[str], *, torque_driven: bool = False, resample: bool = False, drop_invalid: bool = False) -> Log:
    """One log; `torque_driven` says that a bare table without references was recorded under torque commanded directly, no loop.

    Raises BadInputError as `read_signals` does.
    """
    if is_run_folder(path):
        run = open_run(path)
        table = signals_of_run(run, axes, resample=resample, drop_invalid=drop_invalid)
        return Log(path.name, table, {axis: stretches_of_run(run, table, axis) for axis in axes})
    table = read_signals(path, axes, resample=resample, drop_invalid=drop_invalid)
    return Log(path.name, table, {axis: _stretches(table, axis, torque_driven) for axis in axes})


def _stretches(table: SignalsTable, axis: str, torque_driven: bool) -> tuple[Stretch, ...]:
    if torque_driven and table.signal(axis, "rate_ref") is None and table.signal(axis, "position_ref") is None:
        return (Stretch(f"{axis}, whole table", 0, len(table), Drive.TORQUE),)
    return tuple(replace(stretch, drive=Drive.LOOP) for stretch in stretches_of_table(table, axis))
