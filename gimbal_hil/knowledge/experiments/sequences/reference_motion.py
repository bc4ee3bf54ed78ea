"""Motions of both axes along position references: what surveys and separating runs are made of.

A motion is one measured step, so its log has no seams. References are laid out as corners (time, position) joined by
straight lines, whose corners are then rounded; sines may ride on top.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.experiments import Experiment, Row, Signals, Step, axes_of, move_to, position_hold, step_of
from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions
from gimbal_hil.loop.host import AxisCommand, Mode, Shape
from gimbal_hil.pages.report import Block, Callout, Heading, Plot, Text, quantity

Floats = NDArray[np.float64]
#: seconds between rows of a reference; the host goes straight from one to the next
ROW_S = 0.001
#: a corner is rounded over this time on either side
ROUNDED_S = 0.15
#: at rest before a motion, then so long to its start
REST_S, TO_START_S = 0.5, 2.0


@dataclass
class ReferencePath:
    """Corners of one axis' reference, in the order in which they are passed."""

    times_s: list[float] = field(default_factory=lambda: [0.0])
    positions_rad: list[float] = field(default_factory=lambda: [0.0])

    @classmethod
    def at(cls, position_rad: float) -> ReferencePath:
        """A path that begins at a position."""
        return cls([0.0], [position_rad])

    @property
    def end_s(self) -> float:
        """When the last corner is reached."""
        return self.times_s[-1]

    def wait(self, seconds: float) -> ReferencePath:
        """Stay where it is."""
        return self.to(self.positions_rad[-1], seconds)

    def to(self, position_rad: float, seconds: float) -> ReferencePath:
        """Go to a position in a time."""
        self.times_s.append(self.times_s[-1] + seconds)
        self.positions_rad.append(position_rad)
        return self

    def pass_at(self, speed_rad_s: float, travel_rad: float) -> ReferencePath:
        """There and back at a constant speed over a travel; the sign of the travel is the direction in which it
        begins.
        """
        here, seconds = self.positions_rad[-1], abs(travel_rad) / speed_rad_s
        return self.to(here + travel_rad, seconds).to(here, seconds)

    def sampled(self, duration_s: float, rounded_s: float = ROUNDED_S) -> Floats:
        """Positions (rad) every `ROW_S` up to a duration, corners rounded; it stays where it ended."""
        t = np.arange(round(duration_s / ROW_S) + 1) * ROW_S
        straight = np.interp(t, self.times_s, self.positions_rad)
        width = max(1, round(rounded_s / ROW_S))
        window = np.hanning(2 * width + 1)
        return np.asarray(
            np.convolve(np.pad(straight, width, mode="edge"), window / window.sum(), mode="valid"), dtype=np.float64
        )


def motion_experiment(
    name: str, text: str, options: SequenceOptions, references: Mapping[str, Floats], said: str
) -> Experiment:
    """Rest, the way to the start, then the references (rad, one value every `ROW_S`) of both axes as one measured
    step.
    """
    rate = options.rate_hz
    duration_s = ROW_S * (max(map(len, references.values())) - 1)
    follow = [AxisCommand(Mode.POSITION, Shape.TABLE, (ROW_S, 1.0), table=references[axis]) for axis in options.names]
    to_start = [move_to(float(references[axis][0]), 0.75 * TO_START_S) for axis in options.names]
    moving = [axis for axis in options.names if np.ptp(references[axis]) > 0.0]
    steps = (
        step_of("rest", rate, REST_S, 2 * [position_hold(0.0)]),
        step_of("to the start", rate, TO_START_S, to_start),
        step_of(name, rate, duration_s, follow, {"axis": " and ".join(moving)}, measured=True),
    )

    def conclude(rows: Sequence[Row], drawn: Mapping[str, Signals]) -> list[Block]:
        return [*(Callout(_covered(row)) for row in rows), Heading(text), Text(said), *figures(drawn)]

    return Experiment(name, text, steps, measure, conclude, frozenset({name}), options.every or 1)


def measure(step: Step, signals: Signals) -> Row:
    """Ranges covered: position (rad), rate (rad/s) and torque (N m) of each axis."""
    row: Row = {}
    for axis in axes_of(signals):
        for name, unit in (("position", "rad"), ("rate", "rad_s"), ("torque", "nm")):
            column = signals[f"{axis}.{name}"]
            row[f"{axis}_{name}_low_{unit}"], row[f"{axis}_{name}_high_{unit}"] = (
                float(column.min()),
                float(column.max()),
            )
    return row


def _covered(row: Row) -> str:
    """How far each axis went, how fast and under how much torque."""
    mark = "_position_low_rad"

    def largest(axis: str, name: str, unit: str) -> str:
        ends = (row[f"{axis}_{name}_low_{unit}"], row[f"{axis}_{name}_high_{unit}"])
        return quantity(max(map(abs, ends)), {"rad_s": "rad/s", "nm": "N m"}[unit])

    said = [
        f"{axis} from {row[f'{axis}{mark}']:.2f} to {row[f'{axis}_position_high_rad']:.2f} rad, at up to "
        f"{largest(axis, 'rate', 'rad_s')} and {largest(axis, 'torque', 'nm')}"
        for axis in (name.removesuffix(mark) for name in row if name.endswith(mark))
    ]
    return f"Recorded: {'; '.join(said)}."


def figures(drawn: Mapping[str, Signals]) -> list[Block]:
    """What was followed: joint positions and commanded torques over time."""
    from gimbal_hil.pages.plots import AXIS_COLOURS, peaks_kept, stacked

    blocks: list[Block] = []
    for signals in drawn.values():
        figure = stacked(("", ""), "time [s]", ("position [rad]", "torque [N m]"), 190)
        for axis, colour in zip(axes_of(signals), AXIS_COLOURS, strict=True):
            line = dict(color=colour)
            few, peaks = (peaks_kept(signals[f"{axis}.{name}"]) for name in ("position", "torque"))
            figure.add_scatter(
                x=signals["time_s"][few], y=signals[f"{axis}.position"][few], name=axis, line=line, row=1
            )
            figure.add_scatter(
                x=signals["time_s"][peaks], y=signals[f"{axis}.torque"][peaks], showlegend=False, line=line, row=2
            )
        blocks.append(Plot(figure, "Joint positions and commanded torques."))
    return blocks


def both_or_held(
    options: SequenceOptions, paths: Mapping[str, Floats], held_rad: Mapping[str, float] | None = None
) -> dict[str, Floats]:
    """References of the axes asked for; an axis that was not asked for holds a position (0 unless given)."""
    longest = max(len(paths[axis]) for axis in options.axes)
    found = {}
    for axis in options.names:
        at = (held_rad or {}).get(axis, 0.0)
        own = paths[axis] if axis in options.axes else np.full(longest, at)
        found[axis] = np.pad(own, (0, longest - len(own)), mode="edge") if len(own) < longest else own
    return found
