"""Gravity map: the torque that holds each axis over its travel, as the mean of slow passes from both sides.

At rest friction may take any share of the load, so nothing is measured at rest: the joint creeps through each window of
the travel in both directions; half the sum is what depends on position (gravity, a cable), half the difference is
friction.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

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
    position_hold,
    step_of,
)
from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions
from gimbal_hil.loop.host import AxisCommand, Mode, Shape
from gimbal_hil.pages.plots import Drawing
from gimbal_hil.pages.report import Block, Callout, Details, Heading, Plot, Table

#: half of the travel, rad, and windows over all of it
HALF_TRAVEL_RAD, WINDOWS = (1.5, 1.5), 30
SHORT_WINDOWS = 8
SPEED_RAD_S, SHORT_SPEED_RAD_S = 0.05, 0.2
#: travel before the first window, until bristles and loop have settled
RUN_UP_S = 1.5
#: left out at either end of a window
MARGIN = 0.02


def build(options: SequenceOptions) -> Experiment:
    """Up and down over the travel of each axis asked for."""
    steps: list[Step] = []
    speed = SHORT_SPEED_RAD_S if options.short else SPEED_RAD_S
    run_up = RUN_UP_S * speed
    for axis in options.axes:
        half = options.by_axis(HALF_TRAVEL_RAD)[axis]
        edges = np.linspace(-half, half, (SHORT_WINDOWS if options.short else WINDOWS) + 1).tolist()
        home = options.on_axis(axis, move_to(-half - run_up, 5.0), move_to(0.0, 5.0))
        steps.append(step_of(f"{axis} to the lower end", options.rate_hz, 6.0, home))
        for sign, word in ((1, "up"), (-1, "down")):
            steps.append(
                _creep(axis, f"{axis} runs up, going {word}", -sign * (half + run_up), sign * speed, run_up, options)
            )
            for number, (low, high) in enumerate(pairwise(edges) if sign > 0 else reversed(list(pairwise(edges)))):
                margin = MARGIN * (high - low)
                window = number if sign > 0 else len(edges) - 2 - number
                meaning = {
                    "axis": axis,
                    "direction": sign,
                    "window": window,
                    "from_rad": low + margin,
                    "to_rad": high - margin,
                }
                start = low if sign > 0 else high
                name = f"{axis} {word} through {0.5 * (low + high):+.3f} rad"
                steps.append(_creep(axis, name, start, sign * speed, high - low, options, meaning))
            end = sign * half
            steps.append(_creep(axis, f"{axis} runs out, going {word}", end, sign * speed, run_up, options))
        steps.append(
            step_of(f"{axis} back to the middle", options.rate_hz, 4.0, (move_to(0.0, 3.0), move_to(0.0, 3.0)))
        )
    return Experiment(
        "gravity_map", "Holding torque over the travel", tuple(steps), measure, conclude, every=options.every or 1
    )


def _creep(
    axis: str,
    name: str,
    start: float,
    rate: float,
    span: float,
    options: SequenceOptions,
    meaning: Mapping[str, object] | None = None,
) -> Step:
    ramp = AxisCommand(Mode.POSITION, Shape.RAMP, (start, rate, span))
    return step_of(
        name,
        options.rate_hz,
        span / abs(rate),
        options.on_axis(axis, ramp, position_hold(0.0)),
        meaning,
        meaning is not None,
    )


def measure(step: Step, signals: Signals) -> Row | None:
    """Mean torque while the joint passes a window."""
    meaning = step.meaning
    mean = plateau_mean(signals, meaning["axis"], meaning["from_rad"], meaning["to_rad"])
    return None if mean is None else mean.as_row()


@dataclass(frozen=True)
class GravityFit:
    """`constant + cosine cos(q) + sine sin(q)` (N m): a body out of balance on a tilted axis, and what does not turn
    with it.
    """

    constant: float
    cosine: float
    sine: float
    rms: float
    #: standard errors of constant, cosine and sine, from what the fit leaves (N m)
    errors: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def torque(self, position: np.ndarray) -> np.ndarray:
        """Holding torque at positions of any shape."""
        return np.asarray(self.constant + self.cosine * np.cos(position) + self.sine * np.sin(position))


@dataclass(frozen=True)
class Window:
    """A window of the travel: its middle, half its width, and what both directions say about it."""

    middle_rad: float
    half_rad: float
    pair: DirectionPair


def windows_of(rows: Sequence[Row], axis: str) -> list[Window]:
    """Windows in order of position that were passed in both directions."""
    found = []
    for window in sorted({row["window"] for row in rows if row["axis"] == axis}):
        same = [row for row in rows if row["axis"] == axis and row["window"] == window]
        pair = pair_of([row for row in same if row["direction"] > 0], [row for row in same if row["direction"] < 0])
        if pair is not None:
            low, high = same[0]["from_rad"], same[0]["to_rad"]
            found.append(Window(0.5 * (low + high), 0.5 * (high - low), pair))
    return found


def fitted_gravity(windows: Sequence[Window]) -> GravityFit:
    """Least squares over the windows, with sine and cosine averaged over each window as its torque was."""
    place = np.array([window.middle_rad for window in windows])
    torque = np.array([window.pair.positional_nm for window in windows])
    averaging = np.sinc(np.array([window.half_rad for window in windows]) / np.pi)
    design = np.stack([np.ones_like(place), averaging * np.cos(place), averaging * np.sin(place)], axis=1)
    constant, cosine, sine = np.linalg.lstsq(design, torque, rcond=None)[0]
    misfit = torque - design @ np.array([constant, cosine, sine])
    freedom = max(1, len(windows) - design.shape[1])
    errors = np.sqrt(np.diag(np.linalg.pinv(design.T @ design)) * float(misfit @ misfit) / freedom)
    return GravityFit(
        float(constant),
        float(cosine),
        float(sine),
        float(np.sqrt(np.mean(misfit**2))),
        (float(errors[0]), float(errors[1]), float(errors[2])),
    )


def told(fit: GravityFit) -> str:
    """The fit in one sentence: terms that stand above twice their standard error, or that there is none."""
    terms = zip((fit.constant, fit.cosine, fit.sine), fit.errors, ("", " cos q", " sin q"), strict=True)
    seen = [(value, word) for value, error, word in terms if abs(value) > max(2.0 * error, 5e-6)]
    rest = f"what that leaves is {1e3 * fit.rms:.2g} mN m rms"
    if not seen:
        largest = 2e3 * max(fit.errors)
        return f"No holding torque that depends on position, nor a constant one, above {largest:.2g} mN m; {rest}."
    large = max(abs(value) for value, _ in seen) >= 0.1
    said = [f"{abs(value):.4f}{word}" if large else f"{1e3 * abs(value):.2f}{word}" for value, word in seen]
    signs = ["-" if value < 0.0 else "+" for value, _ in seen]
    first = f"{signs[0]}{said[0]}".removeprefix("+")
    formula = " ".join([first, *(f"{sign} {term}" for sign, term in zip(signs[1:], said[1:], strict=True))])
    return f"Holding torque {formula} {'N m' if large else 'mN m'}; {rest}."


def conclude(rows: Sequence[Row], drawn: Mapping[str, Signals]) -> list[Block]:
    """For each axis the map, its first harmonic, and friction over position."""
    blocks: list[Block] = []
    for place, axis in enumerate(dict.fromkeys(row["axis"] for row in rows)):
        windows = windows_of(rows, axis)
        if len(windows) < 4:
            continue
        fit = fitted_gravity(windows)
        blocks += [Heading(f"Gravity over the travel of the {axis} axis"), Callout(told(fit), "good")]
        caption = "Half the sum of both directions with its first harmonic; half the difference is friction."
        blocks.append(Plot(_figure(place, axis, windows, fit), caption))
        blocks.append(Details(f"Every window of the {axis} axis", [_table(windows)]))
    return blocks


def _table(windows: Sequence[Window]) -> Table:
    header = ("Position [rad]", "Holding torque [mN m]", "± [mN m]", "Friction [mN m]", "Steady")
    rows = [
        (
            f"{window.middle_rad:+.3f}",
            f"{round(1e3 * window.pair.positional_nm, 2) + 0.0:+.2f}",
            f"{1e3 * window.pair.positional_error_nm:.2f}",
            f"{1e3 * window.pair.friction_nm:.2f}",
            "yes" if window.pair.steady else "no",
        )
        for window in windows
    ]
    return Table(header, rows)


def _figure(number: int, axis: str, windows: Sequence[Window], fit: GravityFit) -> Drawing:
    from gimbal_hil.pages.plots import AXIS_COLOURS, SECOND, stacked

    place = np.array([window.middle_rad for window in windows])
    pairs = [window.pair for window in windows]
    drawn = stacked(("", ""), "position [rad]", ("holding torque [N m]", "friction [N m]"), 230)
    points = dict(size=7, color=AXIS_COLOURS[number])
    for row, values, errors, name in (
        (1, [p.positional_nm for p in pairs], [2.0 * p.positional_error_nm for p in pairs], "measured"),
        (2, [p.friction_nm for p in pairs], [2.0 * p.friction_error_nm for p in pairs], "friction"),
    ):
        drawn.add_scatter(
            x=place, y=values, error_y=dict(array=errors), mode="markers", name=name, marker=points, row=row
        )
    fine = np.linspace(place[0], place[-1], 200)
    drawn.add_scatter(x=fine, y=fit.torque(fine), mode="lines", name="first harmonic", line=dict(color=SECOND), row=1)
    drawn.update_yaxes(rangemode="tozero", row=2)
    return drawn
