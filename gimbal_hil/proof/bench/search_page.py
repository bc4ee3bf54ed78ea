"""What the search bench found, as text and as blocks of a page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gimbal_hil.pages.report import Block, Heading, Plot, Table, Text
from gimbal_hil.proof.bench.search import LENGTHS_S, Cost, SearchFigures

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing

ASKED_S = 90.0
_HEADER = ("Amount", "Wall time, s", "Processor time, s", "Million sines", "Named")


def search_text(found: SearchFigures) -> str:
    """Both series and their exponents."""
    lines = [
        f"whole catalogue, {found.workers} processes; search on the data, judged on half as much of another motion"
    ]
    for unit, costs in (("s of data", found.by_length), ("candidates", found.by_candidates)):
        for c in costs:
            spent = f"{c.wall_s:7.2f} s, {c.processor_s:7.2f} s of processors, {c.million_sines:4.0f} million sines"
            lines.append(f"  {c.amount:>5g} {unit}: {spent}  {c.verdict}".rstrip())
    length, candidates = found.exponents
    return "\n".join(
        [*lines, f"cost grows as length to the power {length:.2f}, as candidates to the power {candidates:.2f}"]
    )


def search_blocks(found: SearchFigures) -> list[Block]:
    """Section of the results page."""
    length, candidates = found.exponents
    longest = found.by_length[-1]
    return [
        Heading("Search for what is missing"),
        Text(
            f"A ripple is hidden in the virtual antenna; the search on {longest.amount:g} s of both axes at 1 kHz "
            "with the whole"
            f" catalogue took {longest.wall_s:.0f} s on {found.workers} processes (asked: under {ASKED_S:.0f} s for "
            "two minutes)."
            " Cost: processor time of all processes, in sines of the same moments; other users of the machine hardly "
            "bend it."
        ),
        Plot(
            _drawn("Whole search over length of data", "data (s)", found.by_length),
            f"power of the length: {length:.2f}",
        ),
        Plot(
            _drawn("Screening over candidates", "candidates", found.by_candidates),
            f"power of the number of candidates: {candidates:.2f}",
        ),
        Table(
            _HEADER,
            [_row(cost, "s") for cost in found.by_length] + [_row(cost, "candidates") for cost in found.by_candidates],
        ),
        Text(
            f"Lengths {', '.join(f'{s:g}' for s in LENGTHS_S)} s; each search is judged on half as much of another "
            "motion (at least 15 s)."
        ),
    ]


def _row(cost: Cost, unit: str) -> list[str]:
    return [
        f"{cost.amount:g} {unit}",
        f"{cost.wall_s:.2f}",
        f"{cost.processor_s:.2f}",
        f"{cost.million_sines:.0f}",
        cost.verdict,
    ]


def _drawn(title: str, x_title: str, costs: tuple[Cost, ...]) -> Drawing:
    from gimbal_hil.pages.plots import MEASURED, REFERENCE, figure

    drawn = figure(title, x_title, "cost (million sines)")
    last = costs[-1]
    drawn.add_scatter(
        x=[0.0, last.amount],
        y=[0.0, last.million_sines],
        mode="lines",
        name="in proportion",
        line=dict(color=REFERENCE, dash="dot"),
    )
    drawn.add_scatter(
        x=[c.amount for c in costs],
        y=[c.million_sines for c in costs],
        mode="lines+markers",
        name="measured",
        line=dict(color=MEASURED),
        text=[f"{c.wall_s:.1f} s" for c in costs],
        hovertemplate="%{y:.0f} million sines, %{text}",
    )
    drawn.update_yaxes(rangemode="tozero")
    return drawn
