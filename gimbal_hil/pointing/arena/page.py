"""What the arena found, as text and as blocks of a page."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gimbal_hil.pages.report import Block, Callout, Heading, Plot, Table, Text, counted
from gimbal_hil.pointing.arena.arena import ArenaResult, Entrant
from gimbal_hil.pointing.arena.controllers import least_margin_on
from gimbal_hil.pointing.arena.error_dots import Dots, error_dots, lines_are
from gimbal_hil.pointing.arena.scenarios import Scenario, Score
from gimbal_hil.pointing.arena.steps import best_step_lines, short_name, worst_steps
from gimbal_hil.pointing.arena.trial import TrialOutcome
from sim_backend.model import model_named

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing

_MICRO = 1e6
#: title (`{0}` and `{1}` are the axes), figure of an outcome, factor to the unit of the title
Column = tuple[str, Callable[[TrialOutcome], float], float]
_LINE_OF_SIGHT: Column = ("line of sight, rms [µrad]", lambda one: one.los_rms, _MICRO)
_AXES: tuple[Column, ...] = (
    ("{0}, rms [µrad]", lambda one: one.rms[0], _MICRO),
    ("{1}, rms [µrad]", lambda one: one.rms[1], _MICRO),
)
_PEAKS: tuple[Column, ...] = (
    ("{0}, peak after a reversal [µrad]", lambda one: one.reversal_peak[0], _MICRO),
    ("{1}, peak after a reversal [µrad]", lambda one: one.reversal_peak[1], _MICRO),
)
_STEPS: tuple[Column, ...] = (
    ("overshoot [%]", lambda one: one.overshoot, 1.0),
    ("settling to 2 % [s]", lambda one: one.settling_s, 1.0),
)
#: one for each controller that there is by name
_COLOURS = [
    f"#{one}"
    for one in ["8a94a0", "1f6f8b", "d95f02", "b8860b", "4a8c5c", "6a4c93", "7a5230", "c2579b", "b3261e", "2e4a9e"]
]
#: so that lines can be told apart without their colours
_DASHES = ("solid", "dash", "dot", "dashdot")
#: how many times the best error still counts as the best
_CLOSE = 1.1
_WORST = (
    "Steps are left out; behind is more than 10 % worse than the best controller of a case, and the columns after it "
    "say how many times its error, at most, and where."
)
#: scenarios whose errors are drawn over time, where they are among those run
_DRAWN = 3


def arena_text(found: ArenaResult) -> str:
    """The worst case of every controller, then one line a scenario and antenna."""
    names = [entrant.name for entrant in found.entrants]
    header = ["scenario", "antenna", *names]
    lines = [
        _line_of_sight_row(found, one, antenna)
        for antenna in found.antennas
        for one in hardest_first(found, found.scenarios, antenna)
    ]
    worst = _worst_table(found)
    about = (
        f"line-of-sight error, µrad rms, mean of {counted(found.seeds, 'seed')}; steps: the error at rest, overshoot "
        "in percent, settling in s"
    )
    said = [*_aligned([worst.header, *worst.rows]), "", _WORST] if worst.rows else []
    return "\n".join([*said, "", *_aligned([header, *lines]), "", about])


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]


def hardest_first(found: ArenaResult, scenarios: Sequence[Scenario], antenna: str) -> list[Scenario]:
    """Scenarios by the least line-of-sight error that any controller leaves, largest first."""

    def least(one: Scenario) -> float:
        spreads = [found.spread(one.name, antenna, entrant.name, _LINE_OF_SIGHT[1]) for entrant in found.entrants]
        return min((spread.mean for spread in spreads if spread is not None), default=float("inf"))

    return sorted(scenarios, key=least, reverse=True)


def _line_of_sight_row(found: ArenaResult, scenario: Scenario, antenna: str) -> list[str]:
    cells = []
    for entrant in found.entrants:
        cell = _cell(found, scenario, antenna, entrant.name, _LINE_OF_SIGHT, spread=False)
        if scenario.score is Score.STEP and not found.tripped(scenario.name, antenna, entrant.name):
            more = [_cell(found, scenario, antenna, entrant.name, column, spread=False) for column in _STEPS]
            cell += f" ({more[0]} %, {more[1]}{'' if more[1] == 'never' else ' s'})"
        cells.append(cell)
    return [scenario.name, antenna, *cells]


def _worst_table(found: ArenaResult) -> Table:
    """The worst case of every controller, and how far it is behind the best one."""
    rows = []
    for antenna in found.antennas:
        for entrant in found.entrants:
            worst = found.worst(antenna, entrant.name)
            if worst is None:
                continue
            size = "tripped" if worst[1] == float("inf") else _three_digits(_MICRO * worst[1])
            behind, seen = _behind(found, antenna, entrant.name), ("-", "-", "-")
            if behind is not None:
                seen = f"{behind.count} of {behind.rows}", _three_digits(behind.most), behind.where
            told = "not stable: a limit cycle" if _is_limit_cycle(entrant, antenna) else ""
            rows.append((entrant.name, short_name(antenna), worst[0], size, *seen, told))
    kept = [True, len(found.antennas) > 1, *[True] * 5, any(row[7] for row in rows)]
    header = ("Controller", "Antenna", "Worst case", "rms [µrad]", "Cases behind", "Times the best", "Where", "Loops")
    cut = [[cell for cell, keep in zip(row, kept, strict=True) if keep] for row in (header, *rows)]
    return Table(
        cut[0],
        cut[1:],
        _WORST,
    )


def _three_digits(value: float) -> str:
    """Without an exponent, however large."""
    return f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"


@dataclass(frozen=True)
class _Behind:
    """In how many cases, of how many, a controller is worse than the best one by more than a tenth, and where most."""

    count: int
    rows: int
    most: float
    where: str


def _behind(found: ArenaResult, antenna: str, controller: str) -> _Behind | None:
    """How far a controller is behind the best ones; None where it never is."""
    most, where, count, rows = 1.0, "", 0, 0
    for one in (one for one in found.scenarios if one.score is not Score.STEP):
        spreads = {
            entrant.name: spread.mean
            for entrant in found.entrants
            if (spread := found.spread(one.name, antenna, entrant.name, _LINE_OF_SIGHT[1])) is not None
        }
        if len(spreads) < 2 or controller not in spreads:
            continue
        rows += 1
        times = spreads[controller] / min(spreads.values())
        count += times > _CLOSE
        most, where = max((most, where), (times, one.name))
    return _Behind(count, rows, most, where) if count else None


def _is_limit_cycle(entrant: Entrant, antenna: str) -> bool:
    """Whether loops are not stable on an antenna: their figures are then those of an oscillation."""
    if entrant.law is not None:
        # the search for its numbers kept the margin
        return False
    model = model_named(antenna)
    return least_margin_on(entrant.settings.for_axes(model.axes, model.where), model) <= 0.0


def _best_lines(found: ArenaResult) -> list[str]:
    """For each antenna the controller whose worst case is least, beside the next and the greatest."""
    lines = []
    for antenna in found.antennas:
        worst = [(found.worst(antenna, one.name), one) for one in found.entrants]
        rows = sorted(((case[1], case[0], one) for case, one in worst if case is not None), key=lambda row: row[0])
        if rows:
            size, where, best = rows[0]
            told = f"{best.name} has the smallest worst case on {short_name(antenna)}: {_told_size(size)} ({where})."
            others = [f"{one.name}, {_told_size(size)}" for size, _, one in rows[1:2]]
            if len(rows) > 2:
                size, _, last = rows[-1]
                swings = ", its loops in a limit cycle" if _is_limit_cycle(last, antenna) else ""
                others.append(f"the largest is {_told_size(size)}, of {last.name}{swings}")
            lines.append(" ".join([told, *([f"Next: {'; '.join(others)}."] if others else [])]))
    return lines


def _told_size(size: float) -> str:
    return "stopped by a guard" if size == float("inf") else f"{_three_digits(_MICRO * size)} µrad rms"


def arena_blocks(found: ArenaResult) -> list[Block]:
    """The arena as sections of a results page."""
    moving = [one for one in found.scenarios if one.score is not Score.STEP]
    turning = [one for one in found.scenarios if one.score is Score.REVERSAL]
    steps = [one for one in found.scenarios if one.score is Score.STEP]
    spread = f"means of {found.seeds} seeds, ± their standard deviation" if found.seeds > 1 else "those of one seed"
    about: list[Block] = [
        Heading("What was compared"),
        Text(
            "Host and virtual antenna in lockstep at the configuration's rate, through every frame. The error is that "
            "of the antenna's true joints, on the sensors' side of a structural mode, against the reference: for the "
            "line of sight the angle between where the boresight looks and where it should. Cells of one row differ in "
            f"the controller alone. Figures are {spread}; seeds draw the sensors' noise and the turbulence."
        ),
        Table(("Controller", "What it is"), [(one.name, one.text) for one in found.entrants]),
    ]
    blocks: list[Block] = [Callout(line) for line in _best_lines(found)]
    if moving:
        blocks += [Heading("The worst case of every controller"), _worst_table(found)]
        blocks += [Plot(_dots(found, moving, antenna), _seen_in(found, antenna)) for antenna in found.antennas]
        blocks += [*about, Heading("Line of sight"), *(_tables(found, moving, (_LINE_OF_SIGHT,)))]
        blocks += [Heading("Each axis"), *_tables(found, moving, _AXES)]
    else:
        blocks += [Callout(line) for line in best_step_lines(found, steps)]
        blocks += [Heading("The worst step of every controller"), worst_steps(found, steps), *about]
    if turning:
        blocks += [Heading("Reversals"), *_tables(found, turning, _PEAKS)]
    if steps:
        blocks += [Heading("Steps"), *_tables(found, steps, (*_STEPS, _LINE_OF_SIGHT))]
        blocks.append(
            Text("For steps the line of sight is judged from 2 s after the step on, when it should be at rest.")
        )
    blocks += _drawn_errors(found, [*moving, *steps])
    return blocks


def _tables(found: ArenaResult, scenarios: Sequence[Scenario], columns: Sequence[Column]) -> list[Block]:
    tables: list[Block] = []
    for column in columns:
        for antenna in found.antennas:
            hardest = hardest_first(found, scenarios, antenna)
            across, down = [one.name for one in found.entrants], [one.name for one in hardest]
            cells = [[_cell(found, one, antenna, name, column) for name in across] for one in hardest]
            caption = f"Antenna {short_name(antenna)}: {found.named(column[0], antenna)}."
            what = "Scenario"
            if len(across) > len(down):
                # a page is longer than wide
                what, across, down, cells = "Controller", down, across, [list(row) for row in zip(*cells, strict=True)]
            rows = [[name, *row] for name, row in zip(down, cells, strict=True)]
            tables.append(Table([what, *across], rows, caption))
    return tables


def _cell(
    found: ArenaResult, scenario: Scenario, antenna: str, controller: str, column: Column, spread: bool = True
) -> str:
    tripped = found.tripped(scenario.name, antenna, controller)
    if tripped:
        return tripped.replace("_", " ")
    value = found.spread(scenario.name, antenna, controller, column[1])
    if value is None:
        return "-"
    if math.isinf(value.mean):
        return "never"
    mean, deviation = column[2] * value.mean, column[2] * value.deviation
    decimals = 0 if mean >= 100.0 else 1 if mean >= 10.0 else 2
    told = f"{mean:.{decimals}f}"
    # a deviation that the digits shown do not have is not shown
    if not spread or deviation < 0.5 * 10.0**-decimals:
        return told
    return f"{told} ± {deviation:.{decimals}f}"


def _dots(found: ArenaResult, scenarios: Sequence[Scenario], antenna: str) -> Drawing:
    compared = []
    for place, entrant in enumerate(found.entrants):
        cells = [found.spread(one.name, antenna, entrant.name, _LINE_OF_SIGHT[1]) for one in scenarios]
        sizes = [math.nan if cell is None else _MICRO * cell.mean for cell in cells]
        deviations = [0.0 if cell is None else _MICRO * cell.deviation for cell in cells]
        compared.append(Dots(entrant.name, _COLOURS[place % len(_COLOURS)], sizes, deviations))
    return error_dots(f"Line-of-sight error, antenna {short_name(antenna)}", [one.name for one in scenarios], compared)


def _seen_in(found: ArenaResult, antenna: str) -> str:
    drawn = lines_are(found.seeds)
    return f"On the antenna {short_name(antenna)}, the hardest case on top; the axis is logarithmic.{drawn}"


def _drawn_errors(found: ArenaResult, scenarios: Sequence[Scenario]) -> list[Block]:
    """Errors over time of the first scenarios in which something moves, on the last antenna."""
    from gimbal_hil.pages.plots import figure, logarithm

    antenna, blocks = found.antennas[-1], list[Block]()
    kinds = ("aircraft", "base", "reversals")
    picked = [next((one for one in scenarios if one.name.startswith(kind)), None) for kind in kinds]
    for scenario in [one for one in picked if one is not None][:_DRAWN]:
        drawn = figure(scenario.name, "time [s]", "line-of-sight error [µrad]")
        for place, entrant in enumerate(found.entrants):
            outcomes = found.of(scenario.name, antenna, entrant.name)
            if outcomes and outcomes[0].trace is not None:
                time_s, error = outcomes[0].trace
                line = dict(color=_COLOURS[place % len(_COLOURS)], dash=_DASHES[place % len(_DASHES)])
                drawn.add_scatter(x=time_s, y=_MICRO * error, name=entrant.name, line=line)
        drawn.update_yaxes(**logarithm(error for trace in drawn.to_dict()["data"] for error in trace["y"]))
        blocks.append(Plot(drawn, f"Antenna {short_name(antenna)}, first seed. The first seconds are not judged."))
    return [Heading("Errors over time"), *blocks] if blocks else []
