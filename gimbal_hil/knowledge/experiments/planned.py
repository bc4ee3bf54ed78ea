"""A plan file as an experiment: its segments as steps, and for each measured one what the axes did."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gimbal_hil.knowledge.experiments.experiment import Experiment, Row, Signals, Step, axes_of
from gimbal_hil.knowledge.experiments.plan import Plan, load_plan
from gimbal_hil.loop.host import AXIS_NAMES

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing
    from gimbal_hil.pages.report import Block

#: signals that a picture is made of, at most: they are kept in memory until the end
DRAWN_S = 120.0
#: columns of the table for each axis
_COLUMNS = ("torque_mean_nm", "torque_std_nm", "rate_mean_rad_s", "position_first_rad", "position_last_rad")
_HEADER = (
    "Segment",
    "Time [s]",
    "Axis",
    "Torque, mean [N m]",
    "its spread [N m]",
    "Rate, mean [rad/s]",
    "Position, first [rad]",
    "last [rad]",
)


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
    return Experiment(
        plan.name, plan.text or plan.name, tuple(steps), measure, conclude, _drawn(steps, rate_hz), every or 1
    )


def _drawn(steps: Sequence[Step], rate_hz: float) -> frozenset[str]:
    """Names of the steps that a picture shows: the measured ones from the first on, or all, as far as memory goes."""
    found: list[str] = []
    left_s = DRAWN_S
    for step in [step for step in steps if step.measured] or steps:
        left_s -= step.segment.duration_ticks / rate_hz
        if found and left_s < 0.0:
            break
        found.append(step.name)
    return frozenset(found)


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
    """What the axes did, in a sentence and over time, and one table of all measured segments."""
    from gimbal_hil.pages.report import Callout, Plot, Table, Text, counted

    pictures: list[Block] = []
    if drawn:
        count = "one segment" if len(drawn) == 1 else f"{len(drawn)} segments one after the other"
        caption = f"Of {count}: {', '.join(list(drawn)[:6])}"
        caption += ", and so on." if len(drawn) > 6 else "."
        pictures = [Plot(_figure(axis, list(drawn.values())), caption) for axis in axes_of(next(iter(drawn.values())))]
    if not rows:
        return [Text("No segment of the plan is marked to be measured."), *pictures]
    axes = [name.removesuffix(f"_{_COLUMNS[0]}") for name in rows[0] if name.endswith(_COLUMNS[0])]
    body = [
        [row.get("step", ""), f"{row['duration_s']:.4g}", axis, *(f"{row[f'{axis}_{name}']:.5g}" for name in _COLUMNS)]
        for row in rows
        for axis in axes
    ]
    said = Callout(f"{counted(len(rows), 'segment')} measured. {' '.join(_extent(axis, rows) for axis in axes)}")
    return [said, *pictures, Table(_HEADER, body, "What the axes did in each measured segment.")]


def _extent(axis: str, rows: Sequence[Row]) -> str:
    """Between which ends of segments an axis was, and its mean torques."""
    ends = [row[f"{axis}_position_{end}_rad"] for row in rows for end in ("first", "last")]
    means = [row[f"{axis}_torque_mean_nm"] for row in rows]
    return (
        f"{axis.capitalize()}: {min(ends):.4g} to {max(ends):.4g} rad, mean torques {min(means):.4g} to "
        f"{max(means):.4g} N m."
    )


def _figure(axis: str, parts: Sequence[Signals]) -> Drawing:
    """Position, rate and torque of one axis over the time of the run, a gap between segments."""
    from gimbal_hil.pages.plots import MEASURED, REFERENCE, stacked, thinned

    few = thinned(sum(len(part["time_s"]) for part in parts), 3000)
    began = parts[0]["time_s"][0] if len(parts[0]["time_s"]) else 0.0

    def joined(name: str) -> np.ndarray:
        return np.concatenate([np.append(part[name][few], np.nan) for part in parts])

    panels = ("position [rad]", "rate [rad/s]", "torque [N m]")
    drawn = stacked(("", "", ""), "time [s]", panels, 170, f"The {axis} axis")
    time = joined("time_s") - began
    for row, name in enumerate(("position", "rate", "torque"), start=1):
        reference = f"{axis}.{name}_ref"
        if reference in parts[0] and np.any(np.isfinite(joined(reference))):
            line = dict(color=REFERENCE, dash="dot")
            drawn.add_scatter(x=time, y=joined(reference), name="reference", line=line, showlegend=row == 1, row=row)
        line = dict(color=MEASURED)
        drawn.add_scatter(x=time, y=joined(f"{axis}.{name}"), name="measured", line=line, showlegend=row == 1, row=row)
    return drawn
