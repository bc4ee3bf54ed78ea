"""Rich motion of both axes, for finding what a model lacks: plateaus at many speeds, reversals, small and quick motions.

`survey` and `survey_holdout` follow different trajectories, so that what is found on one can be judged on the other.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.experiments.experiment import AXES, Experiment, Row, Signals, Step, move_to, position_hold, step_of
from gimbal_hil.experiments.sequences.options import SequenceOptions
from gimbal_hil.host import AxisCommand, Mode, Shape
from gimbal_hil.report import Block, Heading, Plot, Text

#: largest excursion (rad) of each axis' slow and quick motion
SLOW_RAD, QUICK_RAD = {"outer": 0.7, "inner": 0.6}, {"outer": 0.05, "inner": 0.05}
#: of each axis: times of a slow triangle's legs (s), frequencies of the quick sines (Hz)
LEGS_S = {False: {"outer": (3.0, 5.0, 8.0), "inner": (2.5, 4.0, 9.0)}, True: {"outer": (4.0, 7.0, 2.5), "inner": (6.0, 3.0, 5.0)}}
QUICK_HZ = {False: {"outer": (0.9, 2.3), "inner": (1.3, 3.1)}, True: {"outer": (1.2, 2.9), "inner": (0.8, 2.6)}}
#: a corner of the triangle is rounded over this time
ROUNDED_S = 0.15


def build(options: SequenceOptions) -> Experiment:
    """The trajectory that a search is made on."""
    return _experiment("survey", options, holdout=False)


def build_holdout(options: SequenceOptions) -> Experiment:
    """Another trajectory, to judge on."""
    return _experiment("survey_holdout", options, holdout=True)


def reference(axis: str, rate_hz: float, duration_s: float, holdout: bool) -> NDArray[np.float64]:
    """Position reference (rad) of an axis, (n,) at the tick rate: a rounded triangle of changing slope, quick sines in its second half."""
    t = np.arange(round(duration_s * rate_hz)) / rate_hz
    legs = LEGS_S[holdout][axis]
    turns = np.concatenate([[0.0], np.cumsum(np.tile(legs, 1 + int(duration_s / sum(legs))))])
    heights = SLOW_RAD[axis] * np.where(np.arange(len(turns)) % 2, 1.0, -1.0) * np.where(np.arange(len(turns)) % 3, 1.0, 0.55)
    heights[0] = 0.0
    triangle = np.interp(t, turns, heights)
    width = max(1, round(ROUNDED_S * rate_hz))
    smooth = np.convolve(np.pad(triangle, width, mode="edge"), np.hanning(2 * width + 1) / np.hanning(2 * width + 1).sum(), mode="valid")
    share = np.clip((t / duration_s - 0.5) / 0.05, 0.0, 1.0)
    quick = sum(np.sin(2 * np.pi * f * t + i) / len(QUICK_HZ[holdout][axis]) for i, f in enumerate(QUICK_HZ[holdout][axis]))
    return np.asarray(smooth + share * QUICK_RAD[axis] * quick, dtype=np.float64)


def _experiment(name: str, options: SequenceOptions, holdout: bool) -> Experiment:
    duration_s = 18.0 if options.short else 60.0
    rate = options.rate_hz
    tables = {axis: reference(axis, rate, duration_s, holdout) for axis in AXES}
    rest = dict.fromkeys(AXES, position_hold(0.0))
    follow = {axis: AxisCommand(Mode.POSITION, Shape.TABLE, (1.0 / rate, 1.0), table=tables[axis]) for axis in AXES}
    to_start = {axis: move_to(float(tables[axis][0]), 1.0) for axis in AXES}
    steps = (
        step_of("rest", rate, 0.5, rest),
        step_of("to the start", rate, 1.5, to_start),
        step_of("survey", rate, duration_s, follow, {"axis": "both"}, measured=True),
    )
    text = "Survey motion of both axes" + (", another trajectory" if holdout else "")
    return Experiment(name, text, steps, measure, conclude, frozenset({"survey"}), options.every or 1)


def measure(step: Step, signals: Signals) -> Row:
    """Ranges covered: position (rad), rate (rad/s) and torque (N m) of each axis."""
    row: Row = {}
    for axis in AXES:
        for name, unit in (("position", "rad"), ("rate", "rad_s"), ("torque", "nm")):
            column = signals[f"{axis}.{name}"]
            row[f"{axis}_{name}_low_{unit}"], row[f"{axis}_{name}_high_{unit}"] = float(column.min()), float(column.max())
    return row


def conclude(rows: Sequence[Row], drawn: Mapping[str, Signals]) -> list[Block]:
    """What was followed, as a figure."""
    from gimbal_hil.report.figures import AXIS_COLOURS, stacked, thinned

    blocks: list[Block] = [
        Heading("Survey motion"),
        Text("Plateaus at several speeds in both directions, reversals, then quick motion on top."),
    ]
    for signals in drawn.values():
        few = thinned(len(signals["time_s"]))
        figure = stacked(("", ""), "time [s]", ("position [rad]", "torque [N m]"), 190)
        for axis in AXES:
            line = dict(color=AXIS_COLOURS[axis])
            figure.add_scatter(x=signals["time_s"][few], y=signals[f"{axis}.position"][few], name=axis, line=line, row=1, col=1)
            figure.add_scatter(x=signals["time_s"][few], y=signals[f"{axis}.torque"][few], showlegend=False, line=line, row=2, col=1)
        blocks.append(Plot(figure, "Joint positions and commanded torques."))
    return blocks
