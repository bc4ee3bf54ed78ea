"""What a campaign found, as a page: how each measured number is distributed over the antennas."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.pages.report import Block, Callout, Heading, Page, Plot, Table

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing

_QUANTILES = (0.0, 0.05, 0.5, 0.95, 1.0)
_HEADER = ("Number", "Nominal", "Least", "5 %", "Median", "95 %", "Most", "Antennas without")
#: kinds of numbers that are drawn; the table has all
_MOST_PICTURES = 12


def campaign_page(table: Path, title: str, where: str) -> Page:
    """The page of a finished table."""
    columns, problems = _read(table)
    measured = {name: values for name, values in columns.items() if ": " in name}
    drawn = {name: values for name, values in columns.items() if name not in measured}
    failed = [text for text in problems if text]
    said = f"{len(problems) - 1} antennas and the nominal one; {len(failed)} did not finish the experiment."
    kinds = list(dict.fromkeys(name.rpartition(": ")[2] for name in measured))
    blocks: list[Block] = [
        Callout(said + (f" The first: {failed[0]}." if failed else ""), "warning" if failed else "good"),
        *(Plot(_spread(kind, measured), _CAPTION) for kind in kinds[:_MOST_PICTURES]),
        Heading("What was measured"),
        Table(_HEADER, [_row(name, values) for name, values in measured.items()]),
        Heading("What differs from antenna to antenna"),
        Table(_HEADER, [_row(name, values) for name, values in drawn.items()]),
    ]
    return Page(title, where, blocks)


_CAPTION = (
    "Dots: the median of the antennas, and the nominal one; bars: where nine tenths and the middle half of them are."
)
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
    spread = [f"{q:.4g}" for q in np.quantile(found, _QUANTILES)] if len(found) else ["–"] * len(_QUANTILES)
    return [name, f"{values[0]:.4g}", *spread, str(len(values) - 1 - len(found))]


def _title(kind: str) -> str:
    """`settling_s` as words and a unit."""
    ending = next((ending for ending in _UNITS if kind.endswith(ending)), "")
    words = kind.removesuffix(ending).replace("_", " ")
    return f"{words} [{_UNITS[ending]}]" if ending else words


def _spread(kind: str, measured: Mapping[str, NDArray[np.float64]]) -> Drawing:
    """One kind of number in every step that measured it; quantiles only, so that the page does not grow."""
    from gimbal_hil.pages.plots import ALERT, MEASURED, REFERENCE, figure

    picked = {name.rpartition(": ")[0]: values for name, values in measured.items() if name.endswith(f": {kind}")}
    drawn = figure(_title(kind), "", _title(kind))
    quantiles = np.array([np.nanquantile(values, (0.05, 0.25, 0.5, 0.75, 0.95)) for values in picked.values()]).T
    low, q1, median, q3, high = quantiles
    steps = list(picked)
    for name, least, most, colour, width in (
        ("5 to 95 %", low, high, REFERENCE, 4),
        ("25 to 75 %", q1, q3, MEASURED, 8),
    ):
        reach = dict(type="data", symmetric=False, array=most - median, arrayminus=median - least)
        drawn.add_scatter(
            x=steps,
            y=median,
            mode="markers",
            name=name,
            marker=dict(color=colour, size=width),
            error_y=dict(color=colour, thickness=width, width=0, **reach),
        )
    nominal = [values[0] for values in picked.values()]
    drawn.add_scatter(x=steps, y=nominal, mode="markers", name="nominal", marker=dict(color=ALERT, size=7))
    return drawn
