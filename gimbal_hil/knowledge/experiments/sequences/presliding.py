"""Presliding: torque ramps below and through break-away, unloading loops, pulses: bristle stiffness, break-away,
damping.

Torques count from the torque that held the joint when its step began, so that the inner axis may hang on its gravity.
Before each step the joint is moved to and fro by less and less: what the bristles remember of its arrival is gone then.
A ramp ends when the joint has broken away, and the next step catches it in position mode.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.experiments import Experiment, Row, Signals, Step, move_to, position_hold, step_of
from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions
from gimbal_hil.loop.host import AxisCommand, EndCondition, EndKind, Guard, Mode, ReferenceOrigin, Shape
from gimbal_hil.pages.plots import Drawing
from gimbal_hil.pages.report import Block, Callout, Details, Heading, Plot, Table, Text


class _Kind(StrEnum):
    """What a step does; the column `kind` of the table."""

    RAMP = "ramp"
    LOOP = "loop"
    PULSES = "pulses"


#: what one sees in the figure of each kind
_CAPTIONS = {
    _Kind.RAMP: "Ramps through break-away, both signs and all rates; the slide is cut off. Torque counts from the load "
    "in the middle between break-away up and down: a ramp begins with whatever its bristles held.",
    _Kind.LOOP: "Loops below break-away: torque from the hold over displacement. The slope at zero friction is the "
    "stiffness.",
    _Kind.PULSES: "Pulses below break-away over time: how the joint comes to rest on its bristles holds the damping.",
}
#: seconds in which a ramp rises by one break-away torque
RAMPS_S, SHORT_RAMPS_S = (20.0, 8.0, 3.0), (8.0,)
#: a ramp that has not broken the joint away by then is over, as a multiple of the break-away torque
HIGHEST_SHARE = 2.5
#: torques of the loops, as shares of break-away, and the seconds from one to the next
LOOP_SHARES, LEG_S = (0.0, 0.0, 0.6, 0.2, 0.6, -0.6, -0.2, -0.6, 0.6, -0.6, 0.0), 2.5
LOOPS, SHORT_LOOPS = 3, 1
PULSE_SHARE, PULSE_S, PULSE_PERIOD_S, PULSES, PULSE_EDGE_S = 0.45, 0.1, 1.0, 6, 0.01
#: each torque rests so long before it changes, until the joint is in balance with it
BALANCE_S = 0.8
#: the joint has broken away at this rate, held so long
BROKEN_AWAY_RAD_S, BROKEN_AWAY_S = 0.01, 0.005
#: the rate at which a ramp's torque is read as break-away
CREEP_RAD_S = 4e-3
#: no step may lead the joint further away than this
GUARD_RAD = 0.3
#: moves that wipe out what the bristles remember, rad, and the seconds from one to the next
_RELAXING_RAD = (0.0, 2.0e-3, -1.6e-3, 1.25e-3, -1.0e-3, 8.0e-4, -6.0e-4, 4.5e-4, -3.0e-4, 2.0e-4, -1.0e-4, 0.0)
_RELAXING_LEG_S, _REST_S = 0.3, 2.0


def build(options: SequenceOptions) -> Experiment:
    """Ramps of each rate and sign, loops and pulses on each axis asked for."""
    steps: list[Step] = []
    for axis in options.axes:
        steps.append(step_of(f"{axis} to its start", options.rate_hz, 4.0, (move_to(0.0, 3.0), move_to(0.0, 3.0))))
        level = options.breakaway_of(axis)
        for number in range(SHORT_LOOPS if options.short else LOOPS):
            steps += [_relax(axis, f"loop {number + 1}", options), _loop(axis, level, number, options)]
        steps += [_relax(axis, "the pulses", options), _pulses(axis, level, options)]
        for seconds in SHORT_RAMPS_S if options.short else RAMPS_S:
            for sign, word in ((1, "up"), (-1, "down")):
                steps += [
                    _relax(axis, f"ramp {word} in {seconds:g} s", options),
                    _ramp(axis, level, seconds, sign, word, options),
                ]
        steps.append(
            step_of(f"{axis} is caught", options.rate_hz, 1.0, options.on_axis(axis, _here(), position_hold(0.0)))
        )
    drawn = frozenset(step.name for step in steps if step.measured)
    return Experiment(
        "presliding",
        "Presliding: stiffness, damping, break-away",
        tuple(steps),
        measure,
        conclude,
        drawn,
        options.every or 1,
    )


def _here() -> AxisCommand:
    return AxisCommand(Mode.POSITION, Shape.HOLD, (0.0,), ReferenceOrigin.START)


def _guarded(shape: Shape, parameters: tuple[float, ...], table: tuple[float, ...] = ()) -> AxisCommand:
    return AxisCommand(Mode.TORQUE, shape, parameters, ReferenceOrigin.START, Guard(-GUARD_RAD, GUARD_RAD), table)


def _broken_away(axis: str, options: SequenceOptions) -> tuple[EndCondition, ...]:
    return (
        EndCondition(
            EndKind.RATE_ABOVE,
            options.names.index(axis),
            BROKEN_AWAY_RAD_S,
            max(1, round(BROKEN_AWAY_S * options.rate_hz)),
        ),
    )


def _relax(axis: str, before: str, options: SequenceOptions) -> Step:
    moves = AxisCommand(Mode.POSITION, Shape.TABLE, (_RELAXING_LEG_S, 1.0), ReferenceOrigin.START, table=_RELAXING_RAD)
    duration = _RELAXING_LEG_S * len(_RELAXING_RAD) + _REST_S
    return step_of(
        f"{axis} relaxes before {before}", options.rate_hz, duration, options.on_axis(axis, moves, position_hold(0.0))
    )


def _ramp(axis: str, level: float, seconds: float, sign: int, word: str, options: SequenceOptions) -> Step:
    shares = (0.0, *np.arange(0.0, HIGHEST_SHARE, BALANCE_S / seconds).tolist())
    command = _guarded(Shape.TABLE, (BALANCE_S, sign * level), shares)
    meaning = {"axis": axis, "kind": _Kind.RAMP, "direction": sign, "torque_rate_nm_s": level / seconds}
    name = f"{axis} ramp {word} in {seconds:g} s"
    ends = _broken_away(axis, options)
    return step_of(
        name,
        options.rate_hz,
        BALANCE_S * (len(shares) - 1),
        options.on_axis(axis, command, position_hold(0.0)),
        meaning,
        True,
        ends,
    )


def _loop(axis: str, level: float, number: int, options: SequenceOptions) -> Step:
    command = _guarded(Shape.TABLE, (LEG_S, level), LOOP_SHARES)
    meaning = {"axis": axis, "kind": _Kind.LOOP, "pass": number, "amplitude_nm": level * max(LOOP_SHARES)}
    commands = options.on_axis(axis, command, position_hold(0.0))
    ends = _broken_away(axis, options)
    return step_of(
        f"{axis} loop {number + 1}", options.rate_hz, LEG_S * (len(LOOP_SHARES) - 1), commands, meaning, True, ends
    )


def _pulses(axis: str, level: float, options: SequenceOptions) -> Step:
    rests, width, period = (round(seconds / PULSE_EDGE_S) for seconds in (BALANCE_S, PULSE_S, PULSE_PERIOD_S))
    shares = np.zeros(rests + PULSES * period)
    for number in range(PULSES):
        first = rests + number * period
        shares[first : first + width] = PULSE_SHARE * (1.0 if number % 2 == 0 else -1.0)
    command = _guarded(Shape.TABLE, (PULSE_EDGE_S, level), tuple(shares.tolist()))
    meaning = {"axis": axis, "kind": _Kind.PULSES, "amplitude_nm": PULSE_SHARE * level}
    commands = options.on_axis(axis, command, position_hold(0.0))
    ends = _broken_away(axis, options)
    return step_of(f"{axis} pulses", options.rate_hz, PULSE_EDGE_S * len(shares), commands, meaning, True, ends)


def measure(step: Step, signals: Signals) -> Row:
    """Ramps: torque at which the joint moves faster than 4 mrad/s for good; loops: slope at zero friction; all: travel
    (rad).
    """
    meaning = step.meaning
    position = signals[f"{meaning['axis']}.position"] - signals[f"{meaning['axis']}.position"][0]
    torque = signals[f"{meaning['axis']}.torque"]
    held = float(torque[0])
    row: Row = {"holding_torque_nm": held, "travel_rad": float(np.ptp(position))}
    if meaning["kind"] == _Kind.RAMP:
        place = _creeps(signals["time_s"], position)
        row["broke_away"] = place is not None
        row["breakaway_nm"] = None if place is None else float(torque[place])
        row["presliding_rad"] = None if place is None else float(abs(position[place]))
    elif meaning["kind"] == _Kind.LOOP:
        row["stiffness_nm_per_rad"] = _stiffness(torque - held, position, 0.3 * meaning["amplitude_nm"])
    return row


def _creeps(time_s: NDArray[np.float64], position: NDArray[np.float64]) -> int | None:
    """Row from which on the joint stays faster than the creep, over 20 ms each; None when it never breaks away."""
    period = float(time_s[1] - time_s[0])
    span = max(1, round(0.02 / period))
    if len(position) <= span:
        return None
    fast = np.abs(position[span:] - position[:-span]) > CREEP_RAD_S * span * period
    if not fast[-1]:
        return None
    slow = np.flatnonzero(~fast)
    return int(slow[-1]) + span if len(slow) else span


def _stiffness(torque: NDArray[np.float64], position: NDArray[np.float64], limit: float) -> float | None:
    """Mean slope where friction passes through zero on a long leg: there LuGre's dF/dq is sigma0, whatever break-away
    is.
    """
    inside = np.abs(torque) < limit
    edges = np.flatnonzero(np.diff(inside.astype(np.int8))) + 1
    slopes = []
    for part in np.split(np.arange(len(torque)), edges):
        crossed = inside[part[0]] and len(part) > 20 and torque[part[0]] * torque[part[-1]] < 0.0
        if crossed and abs(torque[part[-1]] - torque[part[0]]) > 1.5 * limit:
            # displacement as a parabola of torque: its slope at zero torque is the compliance
            compliance = float(np.polyfit(torque[part], position[part], 2)[1])
            slopes.append(1.0 / compliance if compliance > 0.0 else np.inf)
    return float(np.mean(slopes)) if slopes else None


def conclude(rows: Sequence[Row], drawn: Mapping[str, Signals]) -> list[Block]:
    """For each axis: break-away from both signs, the ramps that show it, the table; loops and pulses folded."""
    blocks: list[Block] = []
    for axis in dict.fromkeys(row["axis"] for row in rows):
        own = [row for row in rows if row["axis"] == axis]
        plots = _plots(axis, own, drawn)
        blocks += [Heading(f"Presliding of the {axis} axis"), _said(own)]
        blocks += [plots.pop(_Kind.RAMP)] if _Kind.RAMP in plots else []
        blocks.append(_table(own))
        if plots:
            blocks.append(Details(f"{' and '.join(plots).capitalize()} of the {axis} axis", list(plots.values())))
    blocks.append(
        Text(
            "gimbal-hil identify fits sigma0 with the exact LuGre curve and sigma1 from the simulated motion, with "
            "intervals."
        )
    )
    return blocks


def _plots(axis: str, own: Sequence[Row], drawn: Mapping[str, Signals]) -> dict[str, Plot]:
    """Figures of an axis by the kind of their steps, of the kinds that there are."""
    plots: dict[str, Plot] = {}
    for kind, caption in _CAPTIONS.items():
        found = {row["step"]: drawn[row["step"]] for row in own if row["kind"] == kind and row["step"] in drawn}
        if found:
            load = _load_of(own) if kind == _Kind.RAMP else None
            plots[kind] = Plot(_figure(axis, kind, found, load), caption)
    return plots


def _load_of(own: Sequence[Row]) -> float | None:
    """Torque in the middle between break-away up and down, N m; None unless ramps of both signs broke away."""
    broken = [
        [
            row["breakaway_nm"]
            for row in own
            if row["kind"] == _Kind.RAMP and row["direction"] == sign and row["broke_away"]
        ]
        for sign in (1, -1)
    ]
    return 0.5 * sum(float(np.mean(torques)) for torques in broken) if all(broken) else None


def _said(own: Sequence[Row]) -> Callout:
    ramps = [row for row in own if row["kind"] == _Kind.RAMP]
    load = _load_of(own)
    if load is None or not all(row["broke_away"] for row in ramps):
        return Callout(
            "Not every ramp broke the joint away: break-away is higher than the sequence reckons with.", "warning"
        )
    up = float(np.mean([row["breakaway_nm"] for row in ramps if row["direction"] > 0]))
    return Callout(
        f"Break-away {1e3 * (up - load):.1f} mN m about a holding torque of {1e3 * load:+.1f} mN m (both signs, "
        f"{len(ramps)} ramps).",
        "good",
    )


def _table(own: Sequence[Row]) -> Table:
    header = (
        "Step",
        "Held at [mN m]",
        "Travel [mrad]",
        "Break-away at [mN m]",
        "Presliding [mrad]",
        "Stiffness [N m/rad]",
    )
    rows = [
        (
            row["step"],
            f"{1e3 * row['holding_torque_nm']:+.1f}",
            f"{1e3 * row['travel_rad']:.3f}",
            _number(row.get("breakaway_nm"), 1e3, "+.1f"),
            _number(row.get("presliding_rad"), 1e3, ".3f"),
            _number(row.get("stiffness_nm_per_rad"), 1.0, ".1f"),
        )
        for row in own
    ]
    caption = (
        f"Break-away is read where the joint becomes faster than {1e3 * CREEP_RAD_S:g} mrad/s for good. With a "
        "Stribeck effect "
        "friction has begun to fall by then: Ts at rest is a little higher, and identify works it out."
    )
    return Table(header, rows, caption)


def _number(value: float | None, scale: float, form: str) -> str:
    return "–" if value is None else format(scale * value, form)


def _figure(axis: str, kind: str, drawn: Mapping[str, Signals], load: float | None) -> Drawing:
    from gimbal_hil.pages.plots import figure, thinned

    over_time = kind == _Kind.PULSES
    x_title = "time [s]" if over_time else "displacement [mrad]"
    picture = figure(
        f"{axis}: {kind}",
        x_title,
        "displacement [mrad]" if over_time else f"torque from the {'hold' if load is None else 'load'} [mN m]",
    )
    for name, signals in drawn.items():
        position = 1e3 * (signals[f"{axis}.position"] - signals[f"{axis}.position"][0])
        torque = 1e3 * (signals[f"{axis}.torque"] - (signals[f"{axis}.torque"][0] if load is None else load))
        few = thinned(len(position), 2000)
        x, y = (signals["time_s"] - signals["time_s"][0], position) if over_time else (position, torque)
        picture.add_scatter(x=x[few], y=y[few], mode="lines", name=name)
    return picture
