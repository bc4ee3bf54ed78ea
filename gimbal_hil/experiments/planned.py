"""A plan file as an experiment: its segments as steps, and for each measured one what the axes did."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gimbal_hil.experiments.experiment import Experiment, Row, Signals, Step, axes_of
from gimbal_hil.experiments.plan import Plan, load_plan
from gimbal_hil.host import AXIS_NAMES

if TYPE_CHECKING:
    from gimbal_hil.report import Block

#: columns of the table for each axis
_COLUMNS = ("torque_mean_nm", "torque_std_nm", "rate_mean_rad_s", "position_first_rad", "position_last_rad")


def experiment_of_file(
    path: Path, rate_hz: float, every: int | None = None, axes: Sequence[str] = AXIS_NAMES
) -> Experiment:
    """The plan in a file, for an antenna with these axes; BadInputError names file and key where it is none."""
    return experiment_of_plan(load_plan(path, axes), rate_hz, every)


def experiment_of_plan(plan: Plan, rate_hz: float, every: int | None = None) -> Experiment:
    """Steps named after their segments (and laps, where there are several); segments marked `measure` bring a row."""
    steps = []
    for label, (lap, segment) in enumerate(plan.in_order()):
        name = segment.name if plan.laps == 1 else f"{segment.name}, lap {lap}"
        meaning = dict(segment.meaning) | ({"repeat": lap} if plan.laps > 1 else {})
        steps.append(Step(name, segment.segment(label, rate_hz, last=False), meaning, segment.measure))
    return Experiment(plan.name, plan.text or plan.name, tuple(steps), measure, conclude, every=every or 1)


def measure(step: Step, signals: Signals) -> Row:
    """Duration (s), and for each axis mean and spread of the torque (N m), mean rate (rad/s), first and last position
    (rad).
    """
    time = signals["time_s"]
    row: Row = {"duration_s": float(time[-1] - time[0]) if len(time) else 0.0}
    for axis in axes_of(signals):
        torque, rate, position = (signals[f"{axis}.{name}"] for name in ("torque", "rate", "position"))
        values = (
            (np.mean(torque), np.std(torque), np.mean(rate), position[0], position[-1])
            if len(time)
            else (0.0,) * len(_COLUMNS)
        )
        row |= {f"{axis}_{column}": float(value) for column, value in zip(_COLUMNS, values, strict=True)}
    return row


def conclude(rows: Sequence[Row], drawn: Mapping[str, Signals]) -> list[Block]:
    """One table of all measured segments."""
    from gimbal_hil.report import Table, Text

    if not rows:
        return [Text("No segment of the plan is marked to be measured.")]
    keys = ["duration_s", *(name for name in rows[0] if name.endswith(_COLUMNS))]
    body = [[str(row.get("step", "")), *(f"{row[key]:.5g}" for key in keys)] for row in rows]
    return [Table(("Segment", *keys), body, "What the axes did in each measured segment.")]
