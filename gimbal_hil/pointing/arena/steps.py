"""What the arena says of steps: which controller comes to rest soonest, and how each does in its worst step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gimbal_hil.pages.report import Table
from gimbal_hil.pointing.arena.arena import ArenaResult, Spread
from gimbal_hil.pointing.arena.scenarios import Scenario

_CAPTION = (
    "The step in which each takes longest to stay within 2 % of it, and its largest overshoot in any, the soonest "
    "first."
)


def short_name(antenna: str) -> str:
    """A model by its name, wherever its file lies."""
    return Path(antenna).name.removesuffix(".yaml")


@dataclass(frozen=True)
class _Worst:
    """A controller on an antenna: its slowest step (s; infinite where it never settles or tripped), and its largest
    overshoot, %.
    """

    controller: str
    settling_s: float
    slowest: str
    overshoot: float
    wildest: str

    @property
    def settles(self) -> str:
        return f"{self.settling_s:.2f} s" if math.isfinite(self.settling_s) else "never"


def best_step_lines(found: ArenaResult, steps: Sequence[Scenario]) -> list[str]:
    """For each antenna the controller that settles soonest in its slowest step, beside the others."""
    lines = []
    for antenna in found.antennas:
        rows = _ranked(found, steps, antenna)
        if not rows:
            continue
        best, never = rows[0], [one.controller for one in rows if not math.isfinite(one.settling_s)]
        if not math.isfinite(best.settling_s):
            lines.append(f"No controller settles in every step on {short_name(antenna)}.")
            continue
        told = f"{best.controller} settles soonest on {short_name(antenna)}: its slowest step takes {best.settles}"
        told += f" ({best.slowest}), its largest overshoot is {best.overshoot:.2f} %."
        told += f" Next: {rows[1].controller}, {rows[1].settles}." if len(rows) > 1 else ""
        told += f" Not settled in every step: {', '.join(never)}." if never else ""
        lines.append(told)
    return lines


def worst_steps(found: ArenaResult, steps: Sequence[Scenario]) -> Table:
    """Slowest step and largest overshoot of every controller."""
    header = ("Controller", "Antenna", "Settled after", "In", "Overshoot [%]", "In")
    rows = [
        (one.controller, short_name(antenna), one.settles, one.slowest, _overshoot(one), one.wildest)
        for antenna in found.antennas
        for one in _ranked(found, steps, antenna)
    ]
    return Table(header, rows, _CAPTION)


def _overshoot(one: _Worst) -> str:
    return f"{one.overshoot:.2f}" if math.isfinite(one.overshoot) else "-"


def _ranked(found: ArenaResult, steps: Sequence[Scenario], antenna: str) -> list[_Worst]:
    rows = []
    for name in (one.name for one in found.entrants):
        settled = [(_most(found.spread(step.name, antenna, name, lambda one: one.settling_s)), step) for step in steps]
        over = [(_most(found.spread(step.name, antenna, name, lambda one: one.overshoot)), step) for step in steps]
        if settled:
            slowest, wildest = max(settled, key=lambda pair: pair[0]), max(over, key=lambda pair: pair[0])
            rows.append(_Worst(name, slowest[0], slowest[1].name, wildest[0], wildest[1].name))
    return sorted(rows, key=lambda one: (one.settling_s, one.overshoot))


def _most(spread: Spread | None) -> float:
    return math.inf if spread is None else spread.mean
