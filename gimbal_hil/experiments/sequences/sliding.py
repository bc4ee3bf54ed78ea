"""Sliding: constant speeds in both directions, the mean torque of each, and the friction-velocity curve through them.

The whole sequence is the thesis' (section 4.3.1): 45 speeds from 0.001 to 0.1 rad/s over 0 to 75 degrees, spaced by equal ratios so
that half of them lie below 0.01 rad/s, where the Stribeck effect is. Each speed is run forward and back between the same positions.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from gimbal_hil.experiments.experiment import Experiment, Row, Signals, Step, move_to, on_axis, position_hold, step_of
from gimbal_hil.experiments.plateau import Pair, pair_of, plateau_mean
from gimbal_hil.experiments.sequences.options import SequenceOptions
from gimbal_hil.host import AxisCommand, Mode, Shape
from gimbal_hil.report import Block, Callout, Heading, Plot, Table, Text

if TYPE_CHECKING:
    from gimbal_hil.identification import StaticFit

SPEEDS = 45
LOWEST_RAD_S, HIGHEST_RAD_S = 0.001, 0.1
TRAVEL_RAD = math.radians(75.0)
#: left out at either end of the travel: bristles settle over a travel, the loop over a time, and both are over by then
MARGIN = 0.1
#: a pass shorter than this is made again, up to so many passes
PASS_S, MOST_PASSES = 60.0, 3
SHORT_SPEEDS, SHORT_TRAVEL_RAD, SHORT_PASS_S = 12, 0.03, 5.0
SHORT_MARGIN = 0.25
#: rows of one step that are kept at most, and the decimations that may be chosen for it
ROWS, DECIMATIONS = 26_000, (1, 5, 20, 100)


def build(options: SequenceOptions) -> Experiment:
    """All speeds on each axis asked for, slowest first so that a first look comes with the friction at rest; both directions in turn."""
    speeds = np.geomspace(LOWEST_RAD_S, HIGHEST_RAD_S, SHORT_SPEEDS if options.short else SPEEDS).tolist()
    steps: list[Step] = []
    for axis in options.axes:
        home = on_axis(axis, move_to(0.0, 3.0), move_to(0.0, 3.0))
        steps.append(step_of(f"{axis} to its start", options.rate_hz, 4.0, home))
        for speed in speeds:
            steps += _both_directions(axis, speed, options)
    every = options.every or (1 if options.short else DECIMATIONS[-1])
    return Experiment("sliding", "Sliding friction at constant speeds", tuple(steps), measure, conclude, every=every)


def _both_directions(axis: str, speed: float, options: SequenceOptions) -> list[Step]:
    travel = max(SHORT_TRAVEL_RAD, SHORT_PASS_S * speed) if options.short else TRAVEL_RAD
    margin = travel * (SHORT_MARGIN if options.short else MARGIN)
    duration = travel / speed
    passes = 1 if options.short else min(MOST_PASSES, max(1, math.ceil(PASS_S / duration)))
    every = 1 if options.every == 1 or options.short else decimation(duration * options.rate_hz)
    steps = []
    for number in range(passes):
        for sign, word in ((1, "forward"), (-1, "back")):
            ramp = AxisCommand(Mode.POSITION, Shape.RAMP, (0.0 if sign > 0 else travel, sign * speed, travel))
            meaning = {"axis": axis, "speed_rad_s": speed, "direction": sign, "pass": number, "from_rad": margin, "to_rad": travel - margin}
            name = f"{axis} {word} {speed:.5f} rad/s, pass {number + 1}"
            step = step_of(name, options.rate_hz, duration, on_axis(axis, ramp, position_hold(0.0)), meaning, measured=True)
            steps.append(replace(step, segment=replace(step.segment, record_every=every)))
    return steps


def decimation(ticks: float) -> int:
    """Keep one row in so many of a step that takes `ticks`: its torque noise is white, so fewer rows cost little."""
    return next((every for every in DECIMATIONS if ticks / every <= ROWS), DECIMATIONS[-1])


def measure(step: Step, signals: Signals) -> Row | None:
    """Mean rate and torque between the two positions that both directions share, with the standard error of the torque."""
    meaning = step.meaning
    mean = plateau_mean(signals, meaning["axis"], meaning["from_rad"], meaning["to_rad"])
    return None if mean is None else mean.as_row()


def pairs_of(rows: Sequence[Row], axis: str) -> list[Pair]:
    """Both directions of each speed together, in order of speed."""
    found = []
    for speed in dict.fromkeys(row["speed_rad_s"] for row in rows if row["axis"] == axis):
        same = [row for row in rows if row["axis"] == axis and row["speed_rad_s"] == speed]
        pair = pair_of([row for row in same if row["direction"] > 0], [row for row in same if row["direction"] < 0])
        if pair is not None:
            found.append(pair)
    return found


def fitted_curve(pairs: Sequence[Pair]) -> StaticFit | None:
    """The steady LuGre curve through the pairs; None where there are too few."""
    from gimbal_hil.identification import Direction, VelocityPoint, fit_static

    points = [
        VelocityPoint(p.speed_rad_s, p.friction_nm, p.friction_error_nm, 0.0, p.passes, (f"{p.speed_rad_s:.5f} rad/s",), 0.0)
        for p in pairs
        if p.steady
    ]
    return fit_static(points, Direction.POSITIVE)


def conclude(rows: Sequence[Row], drawn: Mapping[str, Signals]) -> list[Block]:
    """For each axis: the curve with error bars, what was taken out as positional, and the numbers of the curve."""
    blocks: list[Block] = []
    for axis in dict.fromkeys(row["axis"] for row in rows):
        pairs = pairs_of(rows, axis)
        if not pairs:
            continue
        curve = fitted_curve(pairs)
        unsteady = sum(not pair.steady for pair in pairs)
        said = f"{len(pairs)} speeds from {pairs[0].speed_rad_s:.4g} to {pairs[-1].speed_rad_s:.4g} rad/s; {unsteady} without steady speed."
        blocks += [Heading(f"Friction of the {axis} axis"), Callout(said, "warning" if unsteady else "good")]
        blocks.append(
            Plot(
                _figure(axis, rows, pairs, curve),
                "Half the difference of both directions, in which all that depends on position alone cancels. The fainter points are the "
                "directions one by one, less the torque that depends on position (half their sum, mean over all speeds).",
            )
        )
        if curve is not None:
            blocks.append(_numbers(curve))
        blocks.append(_table(axis, pairs))
    blocks.append(
        Text(
            "`gimbal-hil identify` on this folder fits all seven numbers with intervals, the model's gravity and presliding runs included."
        )
    )
    return blocks


def _numbers(curve: StaticFit) -> Table:
    rows = [
        (e.name, f"{e.fitted:.5g}", f"{e.interval.low:.5g} to {e.interval.high:.5g}", e.unit, e.verdict.value.replace("_", " "))
        for e in curve.estimates
    ]
    return Table(("Parameter", "Value", "95 %", "Unit", "Verdict"), rows, f"Steady LuGre curve; residual {1e3 * curve.rms:.2f} mN m rms.")


def _table(axis: str, pairs: Sequence[Pair]) -> Table:
    header = ("Speed [rad/s]", "Friction [mN m]", "± [mN m]", "Positional [mN m]", "Passes", "Steady")
    rows = [
        (
            f"{pair.speed_rad_s:.5f}",
            f"{1e3 * pair.friction_nm:.2f}",
            f"{1e3 * pair.friction_error_nm:.2f}",
            f"{1e3 * pair.positional_nm:+.2f}",
            str(pair.passes),
            "yes" if pair.steady else "no",
        )
        for pair in pairs
    ]
    return Table(header, rows, f"The {axis} axis; errors are standard errors with autocorrelation counted.")


def _figure(axis: str, rows: Sequence[Row], pairs: Sequence[Pair], curve: StaticFit | None) -> object:
    from gimbal_hil.report.figures import AXIS_COLOURS, MODEL, REFERENCE, figure

    drawn = figure(f"Friction of the {axis} axis over speed", "speed [rad/s]", "friction [N m]", 460)
    level = float(np.mean([pair.positional_nm for pair in pairs]))
    for direction, symbol, name in ((1, "triangle-up-open", "forward"), (-1, "triangle-down-open", "back")):
        own = [row for row in rows if row["axis"] == axis and row["direction"] == direction]
        drawn.add_scatter(
            x=[abs(row["rate_rad_s"]) for row in own],
            y=[direction * (row["torque_nm"] - level) for row in own],
            error_y=dict(array=[2.0 * row["standard_error_nm"] for row in own], thickness=1),
            mode="markers",
            name=name,
            marker=dict(symbol=symbol, size=7, color=REFERENCE),
        )
    drawn.add_scatter(
        x=[pair.speed_rad_s for pair in pairs],
        y=[pair.friction_nm for pair in pairs],
        error_y=dict(array=[2.0 * pair.friction_error_nm for pair in pairs]),
        mode="markers",
        name="both directions, 2 standard errors",
        marker=dict(size=8, color=AXIS_COLOURS[axis]),
    )
    if curve is not None:
        speeds = np.geomspace(pairs[0].speed_rad_s, pairs[-1].speed_rad_s, 200)
        drawn.add_scatter(x=speeds, y=curve.friction.torque(speeds), mode="lines", name="steady LuGre curve", line=dict(color=MODEL))
    drawn.update_xaxes(type="log")
    return drawn
