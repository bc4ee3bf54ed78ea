"""What tuning gave: a configuration before and after in the arena, and what was predicted of its loops."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gimbal_hil.knowledge.tuning import Tuning, margins
from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.pages.report import Block, Callout, Heading, Plot, Table, Text, counted
from gimbal_hil.pointing.arena.arena import ArenaResult, Entrant, Spread, run_arena
from gimbal_hil.pointing.arena.error_dots import Dots, error_dots, lines_are
from gimbal_hil.pointing.arena.scenarios import Scenario

if TYPE_CHECKING:
    from gimbal_hil.knowledge.tuning import LoopFigures
    from gimbal_hil.pages.plots import Drawing

_BEFORE, _AFTER, _MICRO = "before", "tuned", 1e6


def what_tuning_gave(
    scenarios: Sequence[Scenario], antenna: str, before: DaemonSettings, after: DaemonSettings, seeds: int
) -> ArenaResult:
    """Both configurations in the arena on an antenna."""
    entrants = [Entrant(_BEFORE, before, "as it was"), Entrant(_AFTER, after, "tuned")]
    return run_arena(scenarios, [antenna], entrants, seeds)


def gained_text(found: ArenaResult) -> str:
    """The table for the terminal, with the answer above it."""
    rows = [("scenario", "before, µrad", "tuned, µrad", "times smaller"), *_rows(found)]
    widths = [max(len(row[i]) for row in rows) for i in range(4)]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    return "\n".join([_answer(found), *lines])


def gained_blocks(found: ArenaResult, tuning: Tuning, cautions: Sequence[str]) -> list[Block]:
    """The report as sections of a page; `cautions` are numbers that nobody measured."""
    blocks: list[Block] = [
        Callout(_answer(found), tone_of(_pairs(found)), " ".join(_paid_with(tuning, len(cautions)))),
        Plot(_dots(found), f"Line-of-sight error; the axis is logarithmic.{lines_are(found.seeds)}"),
        Table(("Scenario", "Before [µrad]", "Tuned [µrad]", "Times smaller"), _rows(found)),
        Heading("Loops"),
        Table(
            ("Axis", "Loops", "Crossing [rad/s]", "Disk margin", "Gain, phase", "Error [µrad]", "30 % off"),
            [row for one in tuning.axes for row in _loops(one.axis, one.before, one.after)],
            "Predicted by the model, worst over inertias, sliding and stuck: the error of a torque that walks as "
            "friction does, of the sensors' noise and the navigation's drift.",
        ),
    ]
    if cautions:
        blocks += [
            Heading("What nobody measured"),
            Text("Margins hold as far as these numbers of the model do. Their source says that they are assumed."),
            Table(("Assumed",), [(one,) for one in cautions]),
        ]
    return blocks


def _paid_with(tuning: Tuning, assumed: int) -> list[str]:
    """What the loops lost of their margins, of the axis that lost most, and what the margins hang on."""
    found = []
    stable = [one for one in tuning.axes if one.before.margin > 0.0 and one.after.margin > 0.0]
    one = min(stable, key=lambda axis: axis.after.margin / axis.before.margin, default=None)
    if one is not None and one.after.margin < one.before.margin:
        (gain, phase), (less_gain, less_phase) = margins(one.before.margin), margins(one.after.margin)
        found.append(
            f"Paid with margin, most on {one.axis}: a gain of {gain:.1f} would have made it unstable, now one of "
            f"{less_gain:.1f} does; a phase of {phase:.0f} degrees, now {less_phase:.0f}."
        )
    if assumed:
        found.append(f"The margins stand on {counted(assumed, 'number')} of the model that nobody measured.")
    return found


def _rms(found: ArenaResult, scenario: str, name: str) -> float:
    return _spread(found, scenario, name).mean


def _spread(found: ArenaResult, scenario: str, name: str) -> Spread:
    spread = found.spread(scenario, found.antennas[0], name, lambda one: one.los_rms)
    return Spread(math.inf, 0.0) if spread is None else spread


def _pairs(found: ArenaResult) -> dict[str, tuple[float, float]]:
    return {one.name: (_rms(found, one.name, _BEFORE), _rms(found, one.name, _AFTER)) for one in found.scenarios}


def tone_of(pairs: Mapping[str, tuple[float, float]]) -> str:
    """Good where errors, before and after by scenario, became smaller in all, and nothing trips now."""
    ratios = _times_smaller(pairs)
    return "warning" if not ratios or min(ratios.values()) < 1.0 or _tripped(pairs) else "good"


def _tripped(pairs: Mapping[str, tuple[float, float]]) -> list[str]:
    """Scenarios that a guard ends after tuning."""
    return [name for name, (_, after) in pairs.items() if not math.isfinite(after)]


def _times_smaller(pairs: Mapping[str, tuple[float, float]]) -> dict[str, float]:
    """Error before over error after by scenario, of those that neither of them tripped in."""
    ended = {name: pair for name, pair in pairs.items() if all(map(math.isfinite, pair))}
    return {name: before / after for name, (before, after) in ended.items()}


def answered(how: str, pairs: Mapping[str, tuple[float, float]], antenna: str) -> str:
    """How many times smaller errors became, which are before and after by scenario: median, and the worst of all."""
    ratios = _times_smaller(pairs)
    if not ratios:
        return "No scenario was run to its end both before and after: see the table."
    middle, (least, where) = statistics.median(ratios.values()), min((ratio, name) for name, ratio in ratios.items())
    among = f"the median of {len(ratios)} scenarios" if len(ratios) > 1 else f"the only scenario that ended, {where}"
    error = f"the line-of-sight error on the antenna {Path(antenna).stem}"
    said = f"{how}, {error} is {_times(middle)} times smaller in {among}"
    stopped = _tripped(pairs)
    tripped = f" A guard stops it in {', '.join(stopped)}." if stopped else ""
    if least < 1.0:
        return f"{said}. In one it is {1.0 / least:.2f} times larger: {where}.{tripped}"
    return f"{said}, and at least {least:.1f} times.{tripped}"


def _answer(found: ArenaResult) -> str:
    return answered("Tuned", _pairs(found), found.antennas[0])


def _rows(found: ArenaResult) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for one in found.scenarios:
        before, after = _rms(found, one.name, _BEFORE), _rms(found, one.name, _AFTER)
        times = _times(before / after) if math.isfinite(before) and math.isfinite(after) else "-"
        rows.append((one.name, _size(before), _size(after), times))
    return rows


def _times(ratio: float) -> str:
    return f"{ratio:.0f}" if ratio >= 100.0 else f"{ratio:.1f}" if ratio >= 1.0 else f"{ratio:.2f}"


def _size(value: float) -> str:
    return f"{_MICRO * value:.3g}" if math.isfinite(value) else "tripped"


def _loops(axis: str, before: LoopFigures, after: LoopFigures) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for name, one in ((_BEFORE, before), (_AFTER, after)):
        if one.margin == 0.0:
            rows.append((axis, name, "-", "not stable", "-", "-", "-"))
            continue
        gain, phase = margins(one.margin)
        kept = "stable" if one.stable_when_wrong else "not stable"
        cells = f"{one.crossing_rad_s:.0f}", f"{one.margin:.2f}", f"{gain:.2f}, {phase:.0f}°"
        rows.append((axis, name, *cells, f"{_MICRO * one.error_rad:.1f}", kept))
    return rows


def _in_micro(spread: Spread) -> tuple[float, float]:
    return _MICRO * spread.mean, _MICRO * spread.deviation


def _dots(found: ArenaResult) -> Drawing:
    from gimbal_hil.pages.plots import MEASURED, REFERENCE

    names = [one.name for one in found.scenarios]
    compared = [
        Dots(which, colour, *zip(*(_in_micro(_spread(found, name, which)) for name in names), strict=True))
        for which, colour in ((_BEFORE, REFERENCE), (_AFTER, MEASURED))
    ]
    return error_dots("Line-of-sight error", names, compared)
