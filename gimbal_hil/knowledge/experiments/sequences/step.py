"""Step responses: each axis steps out and back while the other holds; a short hold before each shows the noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from gimbal_hil.knowledge.experiments import (
    SETTLING_BAND,
    Experiment,
    Row,
    Signals,
    Step,
    axes_of,
    position_hold,
    step_of,
    step_response,
)
from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions
from gimbal_hil.pages.report import Block, Callout, Details, Plot, Table, Text

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing

#: sizes (rad) that both axes can step to without their torque limits deciding everything
SIZES_RAD = ((0.2, 1.0), (0.2, 0.5))
HOLD_S, RESPONSE_S = 0.5, 2.5


def build(options: SequenceOptions) -> Experiment:
    """Steps of two sizes on each axis asked for."""
    steps: list[Step] = []
    for axis in options.axes:
        for size in options.by_axis(SIZES_RAD)[axis]:
            hold = options.on_axis(axis, position_hold(0.0), position_hold(0.0))
            steps.append(step_of(f"{axis} rests before {size:g} rad", options.rate_hz, HOLD_S, hold))
            for target, word in ((size, "out"), (0.0, "back")):
                commands = options.on_axis(axis, position_hold(target), position_hold(0.0))
                meaning = {"axis": axis, "from_rad": size - target, "to_rad": target}
                steps.append(
                    step_of(
                        f"{axis} {word} {size:g} rad", options.rate_hz, RESPONSE_S, commands, meaning, measured=True
                    )
                )
    drawn = frozenset(step.name for step in steps if step.measured)
    return Experiment(
        "step", "Step responses of the position loops", tuple(steps), measure, conclude, drawn, options.every or 1
    )


def measure(step: Step, signals: Signals) -> Row:
    """Overshoot (%), 2 % settling time (s), mean error of the last fifth (rad), largest torque (N m), motion of the
    other axis (rad).
    """
    axis = step.meaning["axis"]
    (other,) = (name for name in axes_of(signals) if name != axis)
    response = step_response(
        signals["time_s"] - signals["time_s"][0],
        signals[f"{axis}.position"],
        step.meaning["from_rad"],
        step.meaning["to_rad"],
    )
    return {
        "overshoot_percent": response.overshoot_percent,
        "settling_s": response.settling_s,
        "error_rad": response.error,
        "torque_nm": float(np.max(np.abs(signals[f"{axis}.torque"]))),
        "other_axis_rad": float(np.max(np.abs(signals[f"{other}.position"]))),
    }


def conclude(rows: Sequence[Row], drawn: Mapping[str, Signals]) -> list[Block]:
    """The slowest step as a figure, with what the table says marked in it; the table; every other step folded."""
    settled = all(row["settling_s"] is not None for row in rows)
    worst = max((row["settling_s"] or 0.0 for row in rows), default=0.0)
    header = (
        "Step",
        "From [rad]",
        "To [rad]",
        "Overshoot [%]",
        "Settling, 2 % [s]",
        "Error [mrad]",
        "Torque [N m]",
        "Other axis [mrad]",
    )
    table = [
        (
            row["step"],
            f"{row['from_rad']:g}",
            f"{row['to_rad']:g}",
            f"{row['overshoot_percent']:.2f}",
            "–" if row["settling_s"] is None else f"{row['settling_s']:.3f}",
            f"{1e3 * row['error_rad']:+.3f}",
            f"{row['torque_nm']:.2f}",
            f"{1e3 * row['other_axis_rad']:.2f}",
        )
        for row in rows
    ]
    said = (
        f"Every step settled; the slowest took {worst:.2f} s."
        if settled
        else "At least one step did not settle within its time."
    )
    shown = [row for row in rows if row["step"] in drawn]
    plots = {row["step"]: Plot(_figure(row, drawn[row["step"]]), _caption(row)) for row in shown}
    slowest = max(shown, key=_slowness, default=None)
    blocks: list[Block] = [Callout(said, "good" if settled else "warning")]
    if slowest is not None:
        blocks.append(plots.pop(slowest["step"]))
    blocks += [
        Table(
            header,
            table,
            "Settling is the time after which the position stays within 2 % of the step; the error is the mean of the "
            "last fifth.",
        ),
    ]
    blocks.append(
        Text(
            "The other axis holds its position; what it moves is the coupling through the inertia products and the "
            "base of the joint."
        )
    )
    return [*blocks, *(Details(f"Step {name}", [plot]) for name, plot in plots.items())]


def _slowness(row: Row) -> float:
    """Settling time (s); a step that did not settle is slower than any."""
    return float("inf") if row["settling_s"] is None else float(row["settling_s"])


def _caption(row: Row) -> str:
    settled = "not settled" if row["settling_s"] is None else f"settled after {row['settling_s']:.3f} s (dashed)"
    over = f"overshoot {row['overshoot_percent']:.2f} %"
    return f"Position against its reference, gyro rate, commanded torque; {over}, {settled}; dotted: the 2 % band."


def _figure(row: Row, signals: Signals) -> Drawing:
    from gimbal_hil.pages.plots import AXIS_COLOURS, REFERENCE, stacked, thinned

    axis = row["axis"]
    few = thinned(len(signals["time_s"]), 1500)
    time_s = signals["time_s"] - signals["time_s"][0]
    panels = ("position [rad]", "rate [rad/s]", "torque [N m]")
    drawn = stacked(("", "", ""), "time after the step [s]", panels, 150, row["step"])
    colour = dict(color=AXIS_COLOURS[axes_of(signals).index(axis)])
    reference = dict(color=REFERENCE, dash="dot")
    for panel, name, line, word in (
        (1, "position_ref", reference, "reference"),
        (1, "position", colour, "measured"),
        (2, "rate", colour, "measured"),
        (3, "torque", colour | dict(shape="hv"), "measured"),
    ):
        y = signals[f"{axis}.{name}"][few]
        drawn.add_scatter(x=time_s[few], y=y, name=word, line=line, showlegend=panel == 1, row=panel)
    _mark(drawn, row, time_s, signals[f"{axis}.position"])
    return drawn


def _mark(drawn: Drawing, row: Row, time_s: np.ndarray, position: np.ndarray) -> None:
    """The peak of the overshoot, the band that counts as settled, and when it is entered for good."""
    from gimbal_hil.pages.plots import ALERT, REFERENCE

    start, target = row["from_rad"], row["to_rad"]
    size = target - start
    for side in (-1.0, 1.0):
        edge = target + side * SETTLING_BAND * size
        drawn.add_hline(y=edge, color=REFERENCE, width=1, dash="dot", row=1)
    peak = int(np.argmax((position - start) / size))
    drawn.add_scatter(
        x=[time_s[peak]],
        y=[position[peak]],
        mode="markers+text",
        marker=dict(color=ALERT, size=9, symbol="circle-open"),
        text=[f"{row['overshoot_percent']:.2f} %"],
        textposition=f"{'bottom' if size > 0.0 else 'top'} {'left' if peak > len(position) // 2 else 'right'}",
        name="peak",
        row=1,
    )
    if row["settling_s"] is not None:
        drawn.add_vline(x=row["settling_s"], color=ALERT, width=1, dash="dash", row=1)
