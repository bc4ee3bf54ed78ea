"""What a campaign found, as a page: how each measured number is distributed over the antennas."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.pages.report import Block, Callout, Heading, Page, Plot, Table, quantity, scaled_unit

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing

_QUANTILES = (0.0, 0.05, 0.5, 0.95, 1.0)
_HEADER = ("Number", "Nominal", "Least", "5 %", "Median", "95 %", "Most", "Antennas without")
#: kinds of numbers that are drawn; the table has all
_MOST_PICTURES = 12
#: drawn numbers that the headline names; the table has all
_MOST_TOLD = 3


def campaign_page(table: Path, title: str, where: str) -> Page:
    """The page of a finished table."""
    columns, problems = _read(table)
    measured = {name: values for name, values in columns.items() if ": " in name}
    drawn = {name: values for name, values in columns.items() if name not in measured}
    failed = [text for text in problems if text]
    ended = f"{len(failed)} did not finish the experiment" if failed else "all finished the experiment"
    said = f"{len(problems) - 1} antennas and the nominal one: {ended}. Drawn for each: {_listed(list(drawn))}."
    failure = f" The first: {failed[0]}." if failed else ""
    # what differs most comes first, because the headline speaks of it; what a loop leaves next to nothing of comes last
    every = dict.fromkeys(name.rpartition(": ")[2] for name in measured)
    kinds = sorted(every, key=lambda one: (one in _LEFT_OVER, -_width(one, measured)))
    widest = _widest(kinds, measured)
    blocks: list[Block] = [
        Callout(said + failure, "warning", widest) if failed or not widest else Callout(widest, "good", said),
        *(Plot(_spread(kind, measured), _CAPTION) for kind in kinds[:_MOST_PICTURES]),
        Heading("What was measured"),
        *(_table(kind, measured) for kind in kinds),
        Heading("What differs from antenna to antenna"),
        Table(_HEADER, [_row(name, values) for name, values in drawn.items()]),
    ]
    return Page(f"Campaign: {title[:1].lower()}{title[1:]}", where, blocks)


def _listed(names: Sequence[str]) -> str:
    """The first names; how many more there are."""
    more = len(names) - _MOST_TOLD
    return ", ".join(names[:_MOST_TOLD]) + (f" and {more} more" if more > 0 else "") if names else "noise alone"


_CAPTION = (
    "Dots: the median of the antennas; bars: where nine tenths and the middle half of them are. The line is the "
    "nominal antenna, whose value stands beside the name."
)
#: names of measured numbers that say too little by themselves
_CLEARER = {
    "error_rad": "error at rest",
    "other_axis_rad": "largest position of the other axis",
    "torque_nm": "largest torque",
    "settling_s": "settling time",
}
#: errors of a few steps of an encoder: whether they double says little
_LEFT_OVER = frozenset({"error_rad", "other_axis_rad"})
_UNITS = {"_rad_s": "rad/s", "_rad": "rad", "_s": "s", "_percent": "%", "_nm": "N m"}


def _read(table: Path) -> tuple[dict[str, NDArray[np.float64]], list[str]]:
    """Columns of numbers, NaN where a cell is empty, and the problem of each antenna."""
    with table.open(encoding="utf-8", newline="") as file:
        names, *rows = csv.reader(file)
    cells = dict(zip(names, zip(*rows, strict=True), strict=True))
    problems = list(cells.pop("problem"))
    del cells["antenna"]
    return {name: np.array([float(cell or "nan") for cell in column]) for name, column in cells.items()}, problems


def _row(name: str, values: NDArray[np.float64]) -> list[str]:
    found = values[1:][np.isfinite(values[1:])]
    spread = [_digits(q) for q in np.quantile(found, _QUANTILES)] if len(found) else ["–"] * len(_QUANTILES)
    return [name, _digits(values[0]), *spread, str(len(values) - 1 - len(found))]


def _digits(value: float) -> str:
    """Four digits, without an exponent."""
    return "–" if np.isnan(value) else np.format_float_positional(value, precision=4, fractional=False, trim="-")


def _table(kind: str, measured: Mapping[str, NDArray[np.float64]]) -> Table:
    """One kind of number in every step that measured it, in a unit of its size; next to nothing in it is none."""
    picked = _of_kind(kind, measured)
    size = float(np.nanmax(np.abs(list(picked.values())), initial=0.0))
    factor, unit = scaled_unit(size, _unit(kind))
    header = _title(kind) + ("" if unit == "1" else f" [{unit}]")
    rows = [_row(step, np.round(factor * values, 6)) for step, values in picked.items()]
    return Table((header, *_HEADER[1:]), rows)


def _ending(kind: str) -> str:
    return next((ending for ending in _UNITS if kind.endswith(ending)), "")


def _unit(kind: str) -> str:
    """Of `settling_s` s; "1" for a number without one."""
    return _UNITS.get(_ending(kind), "1")


def _words(kind: str) -> str:
    """`settling_s` without its unit."""
    return _CLEARER.get(kind) or kind.removesuffix(_ending(kind)).replace("_", " ")


def _title(kind: str) -> str:
    """`settling_s` as words."""
    return _words(kind).capitalize()


def _of_kind(kind: str, measured: Mapping[str, NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
    """Values (n,) of every step that measured one kind of number, the nominal antenna's first."""
    return {name.rpartition(": ")[0]: values for name, values in measured.items() if name.endswith(f": {kind}")}


def _widest(kinds: Sequence[str], measured: Mapping[str, NDArray[np.float64]]) -> str:
    """The number that differs most from antenna to antenna, in words: against the largest of its kind, because one that
    is next to nothing may double; a percentage is a share already.
    """
    answers = [kind for kind in kinds if kind not in _LEFT_OVER] or kinds
    found = [spread for kind in answers for spread in _spreads(kind, measured)]
    if not found:
        return ""
    _, kind, step, low, high, nominal = max(found)
    factor, unit = scaled_unit(max(abs(low), abs(high)), _unit(kind))
    low, high, nominal = (round(factor * value, 6) for value in (low, high, nominal))
    what = f'{_title(kind)} of the step "{step}" differs most from antenna to antenna'
    return f"{what}: {low:.3g} to {quantity(high, unit)} in nine of ten (nominal {quantity(nominal, unit)})."


def _width(kind: str, measured: Mapping[str, NDArray[np.float64]]) -> float:
    """How much the step of a kind that differs most does, against the largest of its kind."""
    return max((spread[0] for spread in _spreads(kind, measured)), default=0.0)


def _spreads(
    kind: str, measured: Mapping[str, NDArray[np.float64]]
) -> list[tuple[float, str, str, float, float, float]]:
    """(width against the largest of the kind, kind, step, 5 % and 95 % quantile, nominal) of every step."""
    of_kind = _of_kind(kind, measured)
    known = [np.abs(values[np.isfinite(values)]) for values in of_kind.values()]
    size = 100.0 if _unit(kind) == "%" else max(float(np.max(np.concatenate(known), initial=0.0)), 1e-12)
    found = []
    for step, values in of_kind.items():
        if np.isfinite(values[0]) and np.isfinite(values[1:]).any():
            low, high = np.nanquantile(values[1:], (0.05, 0.95))
            found.append(((high - low) / size, kind, step, float(low), float(high), float(values[0])))
    return found


def _spread(kind: str, measured: Mapping[str, NDArray[np.float64]]) -> Drawing:
    """One kind of number in every step that measured it, as the difference from the nominal antenna, which stands at
    the step; quantiles only, so that the page does not grow.
    """
    from gimbal_hil.pages.plots import ALERT, MEASURED, REFERENCE, figure

    picked = _of_kind(kind, measured)
    unit = _unit(kind)
    nominal = np.array([values[0] for values in picked.values()])
    quantiles = np.array([np.nanquantile(values, (0.05, 0.25, 0.5, 0.75, 0.95)) for values in picked.values()]).T
    factor, scaled = scaled_unit(float(np.nanmax(np.abs(quantiles - nominal))), unit)
    low, q1, median, q3, high = factor * (quantiles - nominal)
    across = "difference from the nominal antenna" + ("" if scaled == "1" else f" [{scaled}]")
    drawn = figure(_title(kind), across, "", 130 + 34 * len(picked))
    steps = [f"{step}: {quantity(value, unit)}" for step, value in zip(picked, nominal, strict=True)]
    for name, least, most, colour, width in (
        ("5 to 95 %", low, high, REFERENCE, 4),
        ("25 to 75 %", q1, q3, MEASURED, 8),
    ):
        reach = dict(type="data", symmetric=False, array=most - median, arrayminus=median - least)
        drawn.add_scatter(
            x=median,
            y=steps,
            mode="markers",
            name=name,
            marker=dict(color=colour, size=width),
            error_x=dict(color=colour, thickness=width, width=0, **reach),
        )
    dot = dict(color="#f2c14e", size=8, line=dict(color="#1c2530", width=1))
    drawn.add_scatter(x=median, y=steps, mode="markers", name="median", marker=dot)
    drawn.update_yaxes(autorange="reversed")
    drawn.update_xaxes(tickangle=0, nticks=5)
    drawn.add_vline(x=0.0, color=ALERT, width=1)
    drawn.update_layout(hovermode="closest")
    return drawn
