"""Opens run folders and signals tables as logs, cut into stretches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from gimbal_hil.data.runs import is_run_folder, open_run
from gimbal_hil.data.signals import LogReading, SignalsTable, on_grid, read_signals, signals_of_run
from gimbal_hil.knowledge.identification.evidence import Log
from gimbal_hil.knowledge.identification.segments import Stretch, TorqueSource, stretches_of_run, stretches_of_table
from sim_backend.model import AntennaModel

#: where an experiment with a thinned log keeps the signals of its steps
STEPS_FOLDER = "steps"
_AS_IT_IS = LogReading()


def read_logs(
    path: Path, model: Sequence[str] | AntennaModel, reading: LogReading = _AS_IT_IS, *, torque_driven: bool = False
) -> tuple[Log, ...]:
    """All logs of a path: the tables of its steps where an experiment with a thinned log left them, else the one of
    `read_log`.
    """
    # older runs have theirs as Parquet
    tables = [table for ending in ("npz", "parquet") for table in sorted((path / STEPS_FOLDER).glob(f"*.{ending}"))]
    steps = tables if is_run_folder(path) else []
    one = partial(read_log, model=model, reading=reading)
    if not steps:
        return (one(path, torque_driven=torque_driven),)
    # a step without a reference was driven by torque: the table's own run says so
    logs = (one(step, torque_driven=True) for step in steps)
    return tuple(replace(log, name=f"{path.name}: {STEPS_FOLDER}/{log.name}") for log in logs)


def read_log(
    path: Path, model: Sequence[str] | AntennaModel, reading: LogReading = _AS_IT_IS, *, torque_driven: bool = False
) -> Log:
    """One log; `torque_driven` says that a bare table without references was recorded under torque commanded directly,
    no loop.

    `model` gives the axes; as a model and not names alone, also what torque a current makes. Raises BadInputError as
    `read_signals` does.
    """
    axes = model.axes if isinstance(model, AntennaModel) else model
    resample, rate_hz, drop_invalid = reading.resample, reading.rate_hz, reading.drop_invalid
    if is_run_folder(path):
        run = open_run(path)
        table = signals_of_run(run, axes, resample=resample or rate_hz is not None, drop_invalid=drop_invalid)
        stretches = {axis: stretches_of_run(run, table, axis) for axis in axes}
        return _on_grid(Log(path.name, table, stretches), rate_hz)
    table = read_signals(
        path, model, resample=resample, drop_invalid=drop_invalid, rate_hz=rate_hz, columns=reading.columns
    )
    stated = frozenset(
        axis for axis in axes if reading.columns.states_time_of(axis) or f"{axis}.torque_sampled" in table.columns
    )
    return Log(path.name, table, {axis: _stretches(table, axis, torque_driven) for axis in axes}, stated)


def _on_grid(log: Log, rate_hz: float | None) -> Log:
    """The log of a run at another rate, its stretches at the same times."""
    if rate_hz is None:
        return log
    table = on_grid(log.table, 1.0 / rate_hz)
    share = log.table.period_s * rate_hz

    def moved(one: Stretch) -> Stretch:
        return replace(one, start=int(-(-one.start * share // 1)), stop=min(len(table), int(one.stop * share)))

    return Log(log.name, table, {axis: tuple(map(moved, stretches)) for axis, stretches in log.stretches.items()})


def _stretches(table: SignalsTable, axis: str, torque_driven: bool) -> tuple[Stretch, ...]:
    if torque_driven and table.signal(axis, "rate_ref") is None and table.signal(axis, "position_ref") is None:
        return (Stretch(f"{axis}, whole table", 0, len(table), TorqueSource.TORQUE),)
    return tuple(replace(stretch, drive=TorqueSource.LOOP) for stretch in stretches_of_table(table, axis))
