"""Warm-up: the joint slides to and fro at one speed for a long time; friction and winding temperature of each lap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gimbal_hil.knowledge.experiments import (
    Experiment,
    Row,
    Signals,
    Step,
    move_to,
    plateau_mean,
    position_hold,
    step_of,
)
from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions
from gimbal_hil.loop.host import AxisCommand, Mode, Shape
from gimbal_hil.pages.plots import Drawing
from gimbal_hil.pages.report import Block, Callout, Heading, Plot

SPEED_RAD_S, TRAVEL_RAD = 0.5, 1.5
#: laps (there and back) of the whole sequence, half an hour, and of the short one
LAPS, SHORT_LAPS = 300, 10
#: left out at either end of a pass
MARGIN = 0.25
#: one log row in so many where nobody says otherwise
EVERY = 10


def build(options: SequenceOptions) -> Experiment:
    """Laps on each axis asked for."""
    steps: list[Step] = []
    for axis in options.axes:
        steps.append(
            step_of(
                f"{axis} to its start",
                options.rate_hz,
                4.0,
                options.on_axis(axis, move_to(-0.5 * TRAVEL_RAD, 3.0), move_to(0.0, 3.0)),
            )
        )
        for lap in range(SHORT_LAPS if options.short else LAPS):
            for sign, word in ((1, "forward"), (-1, "back")):
                ramp = AxisCommand(
                    Mode.POSITION, Shape.RAMP, (-sign * 0.5 * TRAVEL_RAD, sign * SPEED_RAD_S, TRAVEL_RAD)
                )
                meaning = {"axis": axis, "lap": lap, "direction": sign}
                commands = options.on_axis(axis, ramp, position_hold(0.0))
                steps.append(
                    step_of(
                        f"{axis} lap {lap + 1} {word}",
                        options.rate_hz,
                        TRAVEL_RAD / SPEED_RAD_S,
                        commands,
                        meaning,
                        True,
                    )
                )
        steps.append(
            step_of(f"{axis} back to the middle", options.rate_hz, 4.0, (move_to(0.0, 3.0), move_to(0.0, 3.0)))
        )
    every = options.every or (1 if options.short else EVERY)
    return Experiment("warm_up", "Friction while the joint warms up", tuple(steps), measure, conclude, every=every)


def measure(step: Step, signals: Signals) -> Row | None:
    """Mean torque in the middle of the travel, the time of the pass, the winding's temperature."""
    axis = step.meaning["axis"]
    reach = (0.5 - MARGIN) * TRAVEL_RAD
    mean = plateau_mean(signals, axis, -reach, reach)
    if mean is None:
        return None
    temperature = signals[f"{axis}.temperature"]
    known = temperature[np.isfinite(temperature)]
    return mean.as_row() | {
        "time_s": float(np.mean(signals["time_s"])),
        "temperature_degc": float(np.mean(known)) if len(known) else None,
    }


def laps_of(rows: Sequence[Row], axis: str) -> list[Row]:
    """Friction of each lap (half the difference of there and back), when, and how warm the winding was."""
    laps: list[Row] = []
    for lap in sorted({row["lap"] for row in rows if row["axis"] == axis}):
        ways = {row["direction"]: row for row in rows if row["axis"] == axis and row["lap"] == lap}
        if set(ways) != {1, -1}:
            continue
        there, back = ways[1], ways[-1]
        degrees = [way["temperature_degc"] for way in (there, back) if way["temperature_degc"] is not None]
        laps.append(
            {
                "time_s": 0.5 * (there["time_s"] + back["time_s"]),
                "friction_nm": 0.5 * (there["torque_nm"] - back["torque_nm"]),
                "error_nm": 0.5 * float(np.hypot(there["standard_error_nm"], back["standard_error_nm"])),
                "temperature_degc": float(np.mean(degrees)) if degrees else None,
            }
        )
    return laps


def conclude(rows: Sequence[Row], drawn: Mapping[str, Signals]) -> list[Block]:
    """Friction over time and temperature; whether the change is more than its error."""
    blocks: list[Block] = []
    for place, axis in enumerate(dict.fromkeys(row["axis"] for row in rows)):
        laps = laps_of(rows, axis)
        if len(laps) < 4:
            continue
        part = max(1, len(laps) // 5)
        first, last = laps[:part], laps[-part:]
        change = float(np.mean([lap["friction_nm"] for lap in last]) - np.mean([lap["friction_nm"] for lap in first]))
        error = float(np.sqrt(np.sum([lap["error_nm"] ** 2 for lap in first + last]))) / part
        said = (
            f"From the first to the last fifth friction changed by {1e3 * change:+.2f} ± {1e3 * 2.0 * error:.2f} "
            "mN m (2 standard errors)."
        )
        blocks += [
            Heading(f"Warm-up of the {axis} axis"),
            Callout(said, "warning" if abs(change) > 2.0 * error else "good"),
        ]
        blocks.append(Plot(_figure(place, axis, laps), f"Each point is one lap at {SPEED_RAD_S:g} rad/s."))
    return blocks


def _figure(place: int, axis: str, laps: Sequence[Row]) -> Drawing:
    from gimbal_hil.pages.plots import ALERT, AXIS_COLOURS, stacked

    time_s = [lap["time_s"] for lap in laps]
    drawn = stacked(("", ""), "time [s]", ("friction [N m]", "winding [degC]"), 210)
    errors = dict(array=[2.0 * lap["error_nm"] for lap in laps])
    colour = dict(color=AXIS_COLOURS[place])
    friction = [lap["friction_nm"] for lap in laps]
    drawn.add_scatter(x=time_s, y=friction, error_y=errors, mode="markers", name="friction", marker=colour, row=1)
    drawn.add_scatter(
        x=time_s, y=[lap["temperature_degc"] for lap in laps], name="temperature", line=dict(color=ALERT), row=2
    )
    return drawn
