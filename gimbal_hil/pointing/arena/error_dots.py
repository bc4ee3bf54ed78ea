"""Errors of scenarios side by side: a row for each, the hardest on top, a dot with its spread for whoever ran it."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing

#: letters of a line of a scenario's name, so that a phone has room for the dots
_LINE_LETTERS = 26
#: pixels of a row, and of what is around the rows
_ROW, _AROUND = 46, 110
#: one for each of those compared, told apart without colour
_SYMBOLS = ("circle", "square", "diamond", "triangle-up", "cross", "x", "star", "triangle-down", "pentagon", "hexagon")


@dataclass(frozen=True)
class Dots:
    """What one of those compared reached: µrad for each scenario, NaN where there is none, and one standard deviation
    over the seeds either way, 0 of a single one.
    """

    name: str
    colour: str
    sizes: Sequence[float]
    deviations: Sequence[float] = ()


def error_dots(title: str, scenarios: Sequence[str], compared: Sequence[Dots]) -> Drawing:
    """Dots over a logarithmic axis, which has no zero that a bar could begin at."""
    from gimbal_hil.pages.plots import figure, logarithm

    def least(place: int) -> float:
        return min((one.sizes[place] for one in compared if math.isfinite(one.sizes[place])), default=math.inf)

    order = sorted(range(len(scenarios)), key=least, reverse=True)
    rows = ["<br>".join(textwrap.wrap(scenarios[place], _LINE_LETTERS)) for place in order]
    drawn = figure(title, "rms [µrad]", "", _AROUND + _ROW * len(rows))
    for number, one in enumerate(compared):
        drawn_over = len(compared) - 1 - number
        spread = [one.deviations[place] for place in order] if any(one.deviations) else []
        error = dict(type="data", array=spread, thickness=1, color=one.colour)
        drawn.add_scatter(
            x=[one.sizes[place] if math.isfinite(one.sizes[place]) else None for place in order],
            y=rows,
            mode="markers",
            name=one.name,
            # an equal one drawn over it leaves a ring
            marker=dict(
                color=one.colour,
                symbol=_SYMBOLS[number % len(_SYMBOLS)],
                size=10 + min(3 * drawn_over, 6),
                opacity=0.85,
            ),
            error_x=error if spread else None,
        )
    drawn.update_xaxes(**logarithm(size for one in compared for size in one.sizes))
    drawn.update_yaxes(autorange="reversed")
    drawn.update_layout(hovermode="y unified")
    return drawn


def lines_are(seeds: int) -> str:
    """What the lines through dots are; there are none of a single seed."""
    return f" Lines through dots: one standard deviation over {seeds} seeds." if seeds > 1 else " Of one seed."
