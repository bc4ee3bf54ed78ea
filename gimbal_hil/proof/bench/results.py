"""The bench as text and as a page: machine, versions, command, figures."""

from __future__ import annotations

import importlib.metadata
import os
import platform
from collections.abc import Sequence

from firmware_protocol.version import __version__
from gimbal_hil.loop.timing import wall_clock_utc
from gimbal_hil.pages.plots import ALERT, MEASURED, Drawing, figure
from gimbal_hil.pages.report import Block, Callout, Heading, Page, Plot, Table, Text
from gimbal_hil.proof.bench.figures import Figure
from gimbal_hil.proof.bench.speed import STEP_WITH

#: pixels of an effect's row, and of what is around the rows
_ROW, _AROUND = 24, 110
_COSTS_CAPTION = "Dots are medians over the pairs, lines their extremes; the upright line is the target: below it."

HEADER = ("Figure", "Value", "Beside", "Ratio", "Spread", "Pairs", "Target")
PACKAGES = ("numba", "numpy", "mujoco", "pin", "pyarrow")


def machine() -> list[tuple[str, str]]:
    """What the figures were measured on."""
    facts = [
        ("gimbal-hil", __version__),
        ("Python", platform.python_version()),
        ("system", f"{platform.system()} {platform.release()}"),
    ]
    facts.append(("processors", str(os.cpu_count())))
    for package in PACKAGES:
        try:
            facts.append((package, importlib.metadata.version(package)))
        except importlib.metadata.PackageNotFoundError:
            facts.append((package, "not installed"))
    return facts


def bench_text(figures: Sequence[Figure]) -> str:
    """The figures as an aligned table."""
    rows = [list(HEADER), *(figure.as_row() for figure in figures)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(HEADER))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    return "\n".join([", ".join(f"{name} {value}" for name, value in machine()), "", *lines])


def speed_blocks(figures: Sequence[Figure]) -> list[Block]:
    """The figures as a section of the results page."""
    effects = [figure for figure in figures if figure.name.startswith(STEP_WITH)]
    about = (
        "Each figure was measured in turn with its reference, pair by pair, in processor time (start: wall time); "
        "ratio is the median over"
        " the pairs, spread its extremes."
    )
    return [
        _targets(figures),
        Heading("Speed"),
        Text(about),
        Table(HEADER, [figure.as_row() for figure in figures if figure not in effects]),
        Heading("What each effect costs"),
        Plot(_costs(effects), _COSTS_CAPTION),
        Table(
            ("Effect", *HEADER[1:]),
            [[figure.name.removeprefix(STEP_WITH).replace("_", " "), *figure.as_row()[1:]] for figure in effects],
        ),
    ]


def _costs(effects: Sequence[Figure]) -> Drawing:
    """A row for each effect, the dearest on top: a dot at the median, its line over the pairs, the target upright."""
    ranked = sorted(effects, key=lambda one: one.ratio, reverse=True)
    drawn = figure("Cost of one effect", "plant step with it over step without [-]", "", _AROUND + _ROW * len(ranked))
    upper = [one.ratio_high - one.ratio for one in ranked]
    lower = [one.ratio - one.ratio_low for one in ranked]
    drawn.add_scatter(
        x=[one.ratio for one in ranked],
        y=[one.name.removeprefix(STEP_WITH).replace("_", " ") for one in ranked],
        mode="markers",
        name="median, extremes",
        marker=dict(color=MEASURED, size=9),
        error_x=dict(type="data", symmetric=False, array=upper, arrayminus=lower, thickness=1, color=MEASURED),
    )
    for limit in sorted({one.target.limit for one in effects if one.target is not None}):
        drawn.add_vline(x=limit, color=ALERT, width=1.5)
    drawn.update_yaxes(autorange="reversed")
    drawn.update_layout(hovermode="y unified")
    return drawn


def _targets(figures: Sequence[Figure]) -> Callout:
    """How many targets were met, and which were not."""
    asked, missed = [one for one in figures if one.target], [one for one in figures if one.problem]
    said = f"{len(asked) - len(missed)} of {len(asked)} targets met on this machine."
    return Callout("\n".join([said, *(f"Missed: {one.problem}." for one in missed)]), "warning" if missed else "good")


#: title and what is below it, by what was measured
_TITLES = {
    "speed": ("Speed", "ratios to references from the same run"),
    "realtime": ("Deadlines in real time", "two processes on this machine, beside a C loop"),
    "search": ("Cost of a search", "for what a model lacks, beside plain sines"),
    "faults": ("Faults", "what each does to a moving antenna, and when it is safe"),
    "soak": ("Soak", "random programs and damaged frames, for hours"),
    "pointing": ("Controllers beside each other", "how well each holds the line of sight, or settles"),
}


def slower_blocks(slower: Sequence[str]) -> list[Block]:
    """What became slower than in the benches before, at the head of the page."""
    return [Callout(f"Slower: {line}.", "warning") for line in slower]


def bench_page(blocks: Sequence[Block], command: str) -> Page:
    """The results page: what was found, on what, by which command."""
    about = [("command", command), ("time", wall_clock_utc()[:16].replace("T", " ") + " UTC"), *machine()]
    titled = next((titles for what, titles in _TITLES.items() if f" {what}" in command), _TITLES["speed"])
    return Page(*titled, [*blocks, Heading("Machine"), Table(("What", "Value"), about)])
