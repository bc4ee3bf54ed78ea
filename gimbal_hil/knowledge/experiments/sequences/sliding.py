"""Sliding: constant speeds in both directions, the mean torque of each, and the friction-velocity curve through them.

The whole sequence is the thesis' (section 4.3.1): 45 speeds from 0.001 to 0.1 rad/s over 0 to 75 degrees, spaced by
equal ratios so that half of them lie below 0.01 rad/s, where the Stribeck effect is. Each speed is run forward and back
between the same positions. All of the travel twice would take a slow speed 44 minutes; so slow speeds pass three
stretches of it, near both ends and in the middle, forward and back each
(docs/decisions/0050-choose-the-slow-speeds-of-sliding-by-travel-passed.md).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from gimbal_hil.knowledge.experiments import (
    DirectionPair,
    Experiment,
    Row,
    Signals,
    Step,
    move_to,
    pair_of,
    plateau_mean,
    pooled,
    position_hold,
    step_of,
)
from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions
from gimbal_hil.loop.host import AxisCommand, Mode, Shape
from gimbal_hil.pages.plots import Drawing
from gimbal_hil.pages.report import Block, Callout, Details, Heading, Plot, Table, Text, quantity

if TYPE_CHECKING:
    from gimbal_hil.knowledge.identification import StaticFit

SPEEDS = 45
LOWEST_RAD_S, HIGHEST_RAD_S = 0.001, 0.1
TRAVEL_RAD = math.radians(75.0)
#: a slow speed passes so many stretches of the travel, evenly spread, each this long in time and travel at least
STRETCHES, STRETCH_S, SHORTEST_RAD = 3, 36.0, 0.05
#: left out at either end of a pass: bristles settle over a travel (eleven lengths of the thesis' softer axis), the loop
#: over a time
MARGIN_RAD, MARGIN_S = 0.012, 1.0
#: passes over the whole travel: as many as this time has room for, and not more than that
PASSES_S, MOST_PASSES = 60.0, 3
#: from the end of one stretch to the start of the next
MOVE_S, MOVE_RAD_S = 1.0, 0.4
SHORT_SPEEDS, SHORT_TRAVEL_RAD, SHORT_PASS_S = 12, 0.04, 5.0
SHORT_MARGIN = 0.25
#: rows of one pass that are kept at most, the ticks in a row that may be chosen for it, and those between two rows of
#: the log
ROWS, DECIMATIONS, LOG_EVERY = 6_500, (1, 2, 5, 10, 20, 50, 100), 100


@dataclass(frozen=True)
class Pass:
    """There and back between two positions at one speed; what is measured lies `margin_rad` inside."""

    from_rad: float
    to_rad: float
    margin_rad: float

    @property
    def travel_rad(self) -> float:
        """One way, rad."""
        return self.to_rad - self.from_rad


def passes_of(speed_rad_s: float) -> tuple[Pass, ...]:
    """The passes of one speed of the whole sequence."""
    stretch = max(SHORTEST_RAD, STRETCH_S * speed_rad_s)
    margin = max(MARGIN_RAD, MARGIN_S * speed_rad_s)
    if STRETCHES * stretch >= TRAVEL_RAD:
        count = min(MOST_PASSES, max(1, round(PASSES_S * speed_rad_s / TRAVEL_RAD)))
        return (Pass(0.0, TRAVEL_RAD, margin),) * count
    starts = np.linspace(0.0, TRAVEL_RAD - stretch, STRETCHES).tolist()
    return tuple(Pass(start, start + stretch, margin) for start in starts)


def _short_passes_of(speed_rad_s: float) -> tuple[Pass, ...]:
    travel = max(SHORT_TRAVEL_RAD, SHORT_PASS_S * speed_rad_s)
    return (Pass(0.0, travel, max(MARGIN_RAD, SHORT_MARGIN * travel)),)


def build(options: SequenceOptions) -> Experiment:
    """All speeds on each axis asked for, slowest first so that a first look comes with the friction at rest; both
    directions in turn.

    Where several axes are asked for and the log is thinned, each axis is a part of its own.
    """
    steps = tuple(step for axis in options.axes for step in _of_axis(axis, options))
    every = options.every or (1 if options.short else LOG_EVERY)
    alone = every == 1 or len(options.axes) == 1
    parts = () if alone else tuple(build(replace(options, axes=(axis,))) for axis in options.axes)
    return Experiment(
        "sliding", "Sliding friction at constant speeds", steps, measure, conclude, every=every, parts=parts
    )


def _of_axis(axis: str, options: SequenceOptions) -> Iterator[Step]:
    speeds = np.geomspace(LOWEST_RAD_S, HIGHEST_RAD_S, SHORT_SPEEDS if options.short else SPEEDS).tolist()
    home = (move_to(0.0, 3.0), move_to(0.0, 3.0))
    yield step_of(f"{axis} to its start", options.rate_hz, 4.0, home)
    stands = 0.0
    for place, speed in enumerate(speeds):
        passes = _short_passes_of(speed) if options.short else passes_of(speed)
        # every other speed from the far end, so that no way between two stretches is long
        for number, one in enumerate(passes if place % 2 == 0 else passes[::-1]):
            if one.from_rad != stands:
                way = options.on_axis(
                    axis, move_to(one.from_rad, abs(one.from_rad - stands) / MOVE_RAD_S), position_hold(0.0)
                )
                duration = MOVE_S + abs(one.from_rad - stands) / MOVE_RAD_S
                yield step_of(
                    f"{axis} to {one.from_rad:.3f} rad before {speed:.5f} rad/s", options.rate_hz, duration, way
                )
                stands = one.from_rad
            yield from _there_and_back(axis, speed, number, one, options)


def _there_and_back(axis: str, speed: float, number: int, one: Pass, options: SequenceOptions) -> Iterator[Step]:
    duration = one.travel_rad / speed
    every = 1 if options.every == 1 or options.short else decimation(duration * options.rate_hz)
    for sign, word in ((1, "forward"), (-1, "back")):
        ramp = AxisCommand(
            Mode.POSITION, Shape.RAMP, (one.from_rad if sign > 0 else one.to_rad, sign * speed, one.travel_rad)
        )
        inside = {"from_rad": one.from_rad + one.margin_rad, "to_rad": one.to_rad - one.margin_rad}
        meaning = {"axis": axis, "speed_rad_s": speed, "direction": sign, "pass": number} | inside
        name = f"{axis} {word} {speed:.5f} rad/s, pass {number + 1}"
        step = step_of(
            name, options.rate_hz, duration, options.on_axis(axis, ramp, position_hold(0.0)), meaning, measured=True
        )
        yield replace(step, every=every)


def decimation(ticks: float) -> int:
    """Ticks in one row of a step that takes `ticks`; the torque of a row is the mean over them."""
    return next((every for every in DECIMATIONS if ticks / every <= ROWS), DECIMATIONS[-1])


def measure(step: Step, signals: Signals) -> Row | None:
    """Mean rate and torque between the two positions that both directions share, with the standard error of the
    torque.
    """
    meaning = step.meaning
    mean = plateau_mean(signals, meaning["axis"], meaning["from_rad"], meaning["to_rad"])
    return None if mean is None else mean.as_row()


def pairs_of(rows: Sequence[Row], axis: str) -> list[DirectionPair]:
    """Both directions of each speed together, in order of speed; each pass is paired over its own stretch."""
    found = []
    for speed in dict.fromkeys(row["speed_rad_s"] for row in rows if row["axis"] == axis):
        same = [row for row in rows if row["axis"] == axis and row["speed_rad_s"] == speed]
        pairs = [
            pair
            for number in sorted({row["pass"] for row in same})
            if (pair := _pair_of_pass(same, number)) is not None
        ]
        if pairs:
            found.append(pooled(pairs))
    return found


def _pair_of_pass(rows: Sequence[Row], number: int) -> DirectionPair | None:
    ways = ([row for row in rows if row["pass"] == number and row["direction"] == sign] for sign in (1, -1))
    return pair_of(*ways)


def fitted_curve(pairs: Sequence[DirectionPair]) -> StaticFit | None:
    """The steady LuGre curve through the pairs; None where there are too few."""
    from gimbal_hil.knowledge.identification import MapHalf, VelocityPoint, fit_static

    points = [
        VelocityPoint(
            p.speed_rad_s,
            p.friction_nm,
            p.friction_error_nm,
            0.0,
            p.passes,
            (f"{p.speed_rad_s:.5f} rad/s",),
            0.0,
            p.jitter_rad_s,
        )
        for p in pairs
        if p.steady
    ]
    return fit_static(points, MapHalf.POSITIVE)


def conclude(rows: Sequence[Row], drawn: Mapping[str, Signals]) -> list[Block]:
    """For each axis: the curve with error bars, what was taken out as positional, and the numbers of the curve."""
    blocks: list[Block] = []
    for place, axis in enumerate(dict.fromkeys(row["axis"] for row in rows)):
        pairs = pairs_of(rows, axis)
        if not pairs:
            continue
        curve = fitted_curve(pairs)
        unsteady = sum(not pair.steady for pair in pairs)
        friction = [pair.friction_nm for pair in pairs]
        said = (
            f"{quantity(min(friction), 'N m')} to {quantity(max(friction), 'N m')} at {len(pairs)} speeds from "
            f"{pairs[0].speed_rad_s:.3g} to {pairs[-1].speed_rad_s:.3g} rad/s; "
            + (f"at {unsteady} the speed was not steady." if unsteady else "each speed was steady.")
        )
        blocks += [Heading(f"Friction of the {axis} axis"), Callout(said, "warning" if unsteady else "good")]
        blocks.append(
            Plot(
                _figure(place, axis, rows, pairs, curve),
                "Half the difference of both directions, in which all that depends on position alone cancels. The "
                "fainter points are the "
                "directions one by one, less the mean torque of both of that speed and stretch.",
            )
        )
        if curve is not None:
            blocks.append(_numbers(curve))
        blocks.append(Details(f"Every speed of the {axis} axis", [_table(axis, pairs)]))
    blocks.append(
        Text(
            "gimbal-hil identify on this folder fits these numbers with the model's gravity; given a run of presliding "
            "too, also the bristles' stiffness and damping."
        )
    )
    return blocks


def _numbers(curve: StaticFit) -> Table:
    rows = [
        (
            e.name.replace("_", " "),
            e.fitted_text,
            e.interval_text,
            e.unit,
            e.verdict.value.replace("_", " "),
        )
        for e in curve.estimates
    ]
    return Table(
        ("Parameter", "Value", "95 %", "Unit", "Verdict"),
        rows,
        f"Steady LuGre curve; residual {1e6 * curve.rms:.3g} µN m rms.",
    )


def _table(axis: str, pairs: Sequence[DirectionPair]) -> Table:
    header = (
        "Speed [rad/s]",
        "Friction [mN m]",
        "± [µN m]",
        "Positional [mN m]",
        "Jitter [µrad/s]",
        "Passes",
        "Steady",
    )
    rows = [
        (
            f"{pair.speed_rad_s:.5f}",
            f"{1e3 * pair.friction_nm:.3f}",
            f"{1e6 * pair.friction_error_nm:.1f}",
            # no minus before a zero
            f"{round(1e3 * pair.positional_nm, 2) + 0.0:+.2f}",
            f"{1e6 * pair.jitter_rad_s:.0f}",
            str(pair.passes),
            "yes" if pair.steady else "no",
        )
        for pair in pairs
    ]
    return Table(
        header,
        rows,
        f"The {axis} axis; ± is one standard error with autocorrelation counted; positional: half the sum of both "
        "directions; jitter: how much the speed fluctuates, rms, which the curve allows for.",
    )


def _figure(
    place: int, axis: str, rows: Sequence[Row], pairs: Sequence[DirectionPair], curve: StaticFit | None
) -> Drawing:
    from gimbal_hil.pages.plots import AXIS_COLOURS, MODEL, REFERENCE, figure, logarithm

    drawn = figure(f"Friction of the {axis} axis over speed", "speed [rad/s]", "friction [N m]", 460)
    both: dict[tuple[float, int], list[float]] = {}
    for row in rows:
        if row["axis"] == axis:
            both.setdefault((row["speed_rad_s"], row["pass"]), []).append(row["torque_nm"])
    for direction, symbol, name in ((1, "triangle-up-open", "forward"), (-1, "triangle-down-open", "back")):
        own = [row for row in rows if row["axis"] == axis and row["direction"] == direction]
        drawn.add_scatter(
            x=[abs(row["rate_rad_s"]) for row in own],
            y=[direction * (row["torque_nm"] - float(np.mean(both[row["speed_rad_s"], row["pass"]]))) for row in own],
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
        marker=dict(size=8, color=AXIS_COLOURS[place]),
    )
    if curve is not None:
        speeds = np.geomspace(pairs[0].speed_rad_s, pairs[-1].speed_rad_s, 200)
        drawn.add_scatter(
            x=speeds, y=curve.friction.torque(speeds), mode="lines", name="steady LuGre curve", line=dict(color=MODEL)
        )
    drawn.update_xaxes(**logarithm(pair.speed_rad_s for pair in pairs))
    return drawn
