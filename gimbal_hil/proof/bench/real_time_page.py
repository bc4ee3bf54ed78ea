"""What the real-time bench found, as text and as blocks of a page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gimbal_hil.loop.timing import Histogram, MissCause
from gimbal_hil.pages.report import Block, Callout, Heading, Plot, Table, Text, counted
from gimbal_hil.proof.bench.real_time import ASKED_COMPUTING_US, ASKED_RATIO, OWN, RealTime

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing

#: times in microseconds
HEADER = (
    "Link",
    "Ticks",
    "Late p50 / p99 / most",
    "C loop",
    "p99 ratio",
    "Turns",
    "Computing p50 / p99",
    "Missed",
    "C missed",
    "Own",
)
_PERCENT = (1.0, 5.0, 10.0, 25.0, 50.0, 75.0, 90.0, 95.0, 99.0, 99.5, 99.9, 99.99)


def rows_of(found: Sequence[RealTime]) -> list[list[str]]:
    """One row a link and rate, under HEADER."""
    rows = []
    for one in found:
        ours, theirs, computing = (h.summary_us() for h in (one.latency, one.reference, one.computing))
        turns = sorted(one.ratios)
        rows.append(
            [
                f"{one.link}, {one.rate_hz:g} Hz",
                str(one.latency.count),
                f"{ours['p50']:.0f} / {ours['p99']:.0f} / {ours['max']:.0f}",
                f"{theirs['p50']:.0f} / {theirs['p99']:.0f} / {theirs['max']:.0f}",
                f"{one.ratio:.2f}",
                f"{turns[0]:.2f} to {turns[-1]:.2f}",
                f"{computing['p50']:.0f} / {computing['p99']:.0f}",
                f"{_share(sum(one.missed.values()), one.latency.count)}",
                f"{_share(one.reference_missed, one.reference.count)}",
                str(one.own_misses),
            ]
        )
    return rows


def cause_rows(found: Sequence[RealTime]) -> list[list[str]]:
    """Missed ticks by cause, a column for each link and rate; last what a C loop misses of work that never changes."""
    rows = [[cause.value.replace("_", " "), *(str(one.missed[cause]) for one in found)] for cause in MissCause]
    # in as many ticks as the daemon made
    stretched = (one.stretched * one.latency.count / max(1, one.working_ticks) for one in found)
    return [*rows, ["C loop with the same work every tick: missed at it", *(f"{count:.0f}" for count in stretched)]]


def real_time_text(found: Sequence[RealTime]) -> str:
    """The figures as aligned tables."""
    causes = [["missed, by cause", *(f"{one.link} {one.rate_hz:g} Hz" for one in found)], *cause_rows(found)]
    missed = "".join(f"\nMISSED {one.problem}" for one in found if one.problem)
    table = _aligned([list(HEADER), *rows_of(found)])
    return f"{table}\n\n{_aligned(causes)}\n\nfirst tick after {_ready(found)}{missed}"


def real_time_blocks(found: Sequence[RealTime]) -> list[Block]:
    """Section of the results page."""
    own = sum(one.own_misses for one in found)
    seconds = sum(one.latency.count / one.rate_hz for one in found)
    blocks: list[Block] = [
        Heading("Real time"),
        *(Callout(f"Missed: {one.problem}.", "warning") for one in found if one.problem),
        Callout(
            f"{counted(own, 'tick')} missed for reasons of the daemon's own in {seconds:.0f} s.",
            "warning" if own else "good",
        ),
        Text(
            "Plant and daemon are two processes; the daemon records every frame and serves its page and metrics. A C "
            "loop (clock_nanosleep,"
            f" same policy, priority and core) takes turns with it. Asked: p99 ratio at most {ASKED_RATIO:g}, "
            "computing p99 under"
            f" {ASKED_COMPUTING_US:.0f} us at 1 kHz, no own miss."
        ),
        Table(
            HEADER,
            rows_of(found),
            "microseconds; late: from deadline to wake-up; computing: from wake-up until all is sent",
        ),
        Text(f"First tick after the start of the daemon's process: {_ready(found)}."),
        Table(
            ("Missed ticks by cause", *(f"{one.link}, {one.rate_hz:g} Hz" for one in found)),
            cause_rows(found),
            "own: "
            + ", ".join(cause.value.replace("_", " ") for cause in OWN)
            + "; a bus wait is the driver's; the others are the machine's. The C loop in the last line adds numbers "
            "for as long as the"
            " daemon computes, the same in every tick; its misses are counted for as many ticks as the daemon made",
        ),
        Plot(
            _latencies(found),
            "share of wake-ups that were later than this; the daemon beside the C loop of the same minutes",
        ),
    ]
    return blocks


def _share(missed: int, ticks: int) -> str:
    return f"{100.0 * missed / max(1, missed + ticks):.3f} %"


def _ready(found: Sequence[RealTime]) -> str:
    seconds = sorted(s for one in found for s in one.ready_s)
    return (
        f"{seconds[0]:.1f} s at best, {seconds[len(seconds) // 2]:.1f} s in the middle of {len(seconds)} starts"
        if seconds
        else "not seen"
    )


def _latencies(found: Sequence[RealTime]) -> Drawing:
    from gimbal_hil.pages.plots import figure

    drawn = figure("Wake-up latency", "late by (us)", "share later than this")
    colours = ("#1f6f8b", "#d1603d", "#6a4c93", "#4f7f3f", "#8a6d1f", "#b3261e")
    for index, one in enumerate(found):
        for what, histogram, dash in (("daemon", one.latency, "solid"), ("C loop", one.reference, "dot")):
            x, y = _tail(histogram)
            name = f"{what}, {one.link} {one.rate_hz:g} Hz"
            drawn.add_scatter(
                x=x, y=y, mode="lines", name=name, line=dict(color=colours[index % len(colours)], dash=dash)
            )
    drawn.update_xaxes(type="log", dtick=1)
    drawn.update_yaxes(type="log", tickformat=".3~%", dtick=1)
    drawn.update_layout(height=460, legend=dict(orientation="v", yanchor="top", y=1.0, xanchor="right", x=1.0))
    return drawn


def _tail(histogram: Histogram) -> tuple[list[float], list[float]]:
    x = [max(histogram.quantile_ns(p / 100.0), 500) / 1e3 for p in _PERCENT]
    return x, [1.0 - p / 100.0 for p in _PERCENT]


def _aligned(rows: list[list[str]]) -> str:
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    )
