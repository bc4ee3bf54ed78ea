"""Step responses: each axis steps out and back while the other holds; a short hold before each shows the noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gimbal_hil.experiments import Experiment, Row, Signals, Step, axes_of, position_hold, step_of, step_response
from gimbal_hil.experiments.sequences.options import SequenceOptions
from gimbal_hil.report import Block, Callout, Heading, Plot, Table, Text

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
    drawn = frozenset(step.name for step in steps if step.measured and step.meaning["to_rad"] != 0.0)
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
    """Table and one figure for each step out."""
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
    blocks: list[Block] = [
        Heading("Step responses"),
        Callout(said, "good" if settled else "warning"),
        Table(
            header,
            table,
            "Settling is the time after which the position stays within 2 % of the step; the error is the mean of the "
            "last fifth.",
        ),
    ]
    for name, signals in drawn.items():
        blocks.append(
            Plot(_figure(name, signals), f"{name}: position against its reference, gyro rate, and commanded torque.")
        )
    blocks.append(
        Text(
            "The other axis holds its position; what it moves is the coupling through the inertia products and the "
            "base of the joint."
        )
    )
    return blocks


def _figure(name: str, signals: Signals) -> object:
    from gimbal_hil.plots import AXIS_COLOURS, REFERENCE, stacked, thinned

    axis = name.split()[0]
    few = thinned(len(signals["time_s"]))
    time_s = (signals["time_s"] - signals["time_s"][0])[few]
    drawn = stacked(("", "", ""), "time after the step [s]", ("position [rad]", "rate [rad/s]", "torque [N m]"), 170)
    colour = dict(color=AXIS_COLOURS[axes_of(signals).index(axis)])
    drawn.add_scatter(
        x=time_s,
        y=signals[f"{axis}.position_ref"][few],
        name="reference",
        line=dict(color=REFERENCE, dash="dot"),
        row=1,
        col=1,
    )
    drawn.add_scatter(x=time_s, y=signals[f"{axis}.position"][few], name="position", line=colour, row=1, col=1)
    drawn.add_scatter(
        x=time_s, y=signals[f"{axis}.rate"][few], name="rate", line=colour, showlegend=False, row=2, col=1
    )
    drawn.add_scatter(
        x=time_s,
        y=signals[f"{axis}.torque"][few],
        name="torque",
        line=colour | dict(shape="hv"),
        showlegend=False,
        row=3,
        col=1,
    )
    return drawn
