"""Opens run folders and signals tables as logs, cut into stretches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from gimbal_hil.identification.evidence import Log
from gimbal_hil.identification.segments import Drive, Stretch, stretches_of_run, stretches_of_table
from gimbal_hil.runs import is_run_folder, open_run
from gimbal_hil.signals import SignalsTable, read_signals, signals_of_run

#: where an experiment with a thinned log keeps the signals of its steps
STEPS_FOLDER = "steps"


def read_logs(
    path: Path, axes: Sequence[str], *, torque_driven: bool = False, resample: bool = False, drop_invalid: bool = False
) -> tuple[Log, ...]:
    """All logs of a path: the tables of its steps where an experiment with a thinned log left them, else the one of `read_log`."""
    steps = sorted((path / STEPS_FOLDER).glob("*.parquet")) if is_run_folder(path) else []
    if not steps:
        return (read_log(path, axes, torque_driven=torque_driven, resample=resample, drop_invalid=drop_invalid),)
    # a step without a reference was driven by torque: the table's own run says so
    logs = (read_log(step, axes, torque_driven=True, resample=resample, drop_invalid=drop_invalid) for step in steps)
    return tuple(replace(log, name=f"{path.name}: {STEPS_FOLDER}/{log.name}") for log in logs)


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
