"""The fault matrix as text and as a section of the results page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gimbal_hil.pages.report import Block, Callout, Heading, Plot, Table, Text
from gimbal_hil.proof.bench.faults.matrix import FaultOutcome
from gimbal_hil.proof.bench.faults.rig import Transport
from gimbal_hil.proof.bench.faults.rows import Motion

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing

HEADER = ("Fault", "Line", "Seen as", "Safe", "Bound", "At rest", "Faster by", "Travel", "Bound", "Verdict")


def matrix_text(found: Sequence[FaultOutcome]) -> str:
    """Every row, then what is to be remembered."""
    rows = [list(HEADER), *map(_cells, found)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(HEADER))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    return "\n".join([*lines, "", *summary(found)])


def matrix_blocks(found: Sequence[FaultOutcome]) -> list[Block]:
    """The answer of the results page, how near each row came to its bounds, and all rows."""
    caption = "Dots: rows, of each line; the upright line is the bound of the row."
    return [
        _answer(found),
        *(Text(_sentence(line)) for line in summary(found)[1:]),
        *_shares("Time until safe", [(one, one.safe_s or 0.0, one.row.safe_s) for one in found], caption),
        *_shares("Travel until at rest", [(one, one.travel_rad, one.row.travel_rad) for one in found], caption),
        Heading("Every fault"),
        Table(HEADER, list(map(_cells, found))),
    ]


def _answer(found: Sequence[FaultOutcome]) -> Callout:
    """Whether every row kept its bounds, and which came nearest; else the first that did not."""
    lines = " and ".join(dict.fromkeys(_line(one) for one in found))
    wrong = [one for one in found if one.problem]
    if wrong:
        first = f"{wrong[0].row.name} on {_line(wrong[0])}: {wrong[0].problem}"
        return Callout(
            f"{len(wrong)} of {len(found)} faults on {lines} did not end as they must. The first: {first}.", "bad"
        )
    slowest = max((one for one in found if one.safe_s is not None), key=lambda one: one.safe_s or 0.0, default=None)
    who = f"All {len(found)} faults" if len(found) > 1 else "The one fault"
    said = f"{who} on {lines} ended safely and within {'their' if len(found) > 1 else 'its'} bounds"
    if slowest is None:
        return Callout(f"{said}.", "good")
    within = f"{slowest.safe_s:.3f} s of {slowest.row.safe_s:.3f} allowed ({slowest.row.name})"
    return Callout(f"{said}, the slowest after {within}.", "good")


def _sentence(line: str) -> str:
    return f"{line[0].upper()}{line[1:]}."


def _shares(title: str, taken: Sequence[tuple[FaultOutcome, float, float]], caption: str) -> list[Block]:
    """How much of its bound each row took, a line for each kind of fault, a colour for each motion; rows without a
    bound, which ride through, are not drawn. `taken` are rows, what each took and its bound.
    """
    shares = [(one, 100.0 * took / bound) for one, took, bound in taken if bound > 0.0 and one.safe_s is not None]
    return [Plot(_dots(title, shares), caption)] if shares else []


def _dots(title: str, shares: Sequence[tuple[FaultOutcome, float]]) -> Drawing:
    from gimbal_hil.pages.plots import ALERT, MEASURED, MODEL, REFERENCE, figure

    kinds = list(dict.fromkeys(_kind(one) for one, _ in shares))
    drawn = figure(title, "share of what is allowed [%]", "", 130 + 26 * len(kinds))
    for motion, colour in zip(Motion, (REFERENCE, MEASURED, MODEL), strict=True):
        own = [(one, share) for one, share in shares if one.row.motion is motion]
        dots = dict(color=colour, size=8, opacity=0.8)
        drawn.add_scatter(
            x=[share for _, share in own],
            y=[_kind(one) for one, _ in own],
            name=str(motion),
            mode="markers",
            marker=dots,
        )
    drawn.add_vline(x=100.0, color=ALERT, width=1.5)
    drawn.update_xaxes(range=[0.0, 1.05 * max(100.0, *(share for _, share in shares))])
    drawn.update_yaxes(autorange="reversed")
    drawn.update_layout(hovermode="closest")
    return drawn


def _line(one: FaultOutcome) -> str:
    return "CAN" if one.transport is Transport.CAN else str(one.transport)


def _kind(one: FaultOutcome) -> str:
    return one.row.name.partition(": ")[2]


def summary(found: Sequence[FaultOutcome]) -> list[str]:
    """How many rows were right, and the worst figures by motion."""
    right = sum(not one.problem for one in found)
    lines = [f"{right} of {len(found)} right ({len({one.row.name for one in found})} rows, each on every line)"]
    for motion in Motion:
        seen = [one for one in found if one.row.motion is motion and one.safe_s is not None and not one.row.may_pass]
        if seen:
            slowest, fastest = max(seen, key=lambda one: one.safe_s or 0.0), max(seen, key=lambda one: one.excess_rad_s)
            furthest = max(seen, key=lambda one: one.travel_rad)
            safe = f"safe within {slowest.safe_s:.3f} s ({slowest.row.name})"
            faster = f"at most {fastest.excess_rad_s:.2f} rad/s faster than before ({fastest.row.name})"
            lines.append(f"{motion}: {safe}, {faster}, {furthest.travel_rad:.2f} rad travelled ({furthest.row.name})")
    return lines


def _cells(one: FaultOutcome) -> list[str]:
    def seconds(value: float | None) -> str:
        return "-" if value is None else f"{value:.3f} s"

    row = one.row
    travel = [f"{one.excess_rad_s:.2f} rad/s", f"{one.travel_rad:.3f} rad", f"{row.travel_rad:.2f} rad"]
    times = [seconds(one.safe_s), seconds(row.safe_s), seconds(one.rest_s)]
    return [row.name, _line(one), one.cause.replace("_", " "), *times, *travel, one.problem or "right"]
