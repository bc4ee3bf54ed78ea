"""The fault matrix as text and as a section of the results page."""

from __future__ import annotations

from collections.abc import Sequence

from gimbal_hil.pages.report import Block, Heading, Table, Text
from gimbal_hil.proof.bench.faults.matrix import FaultOutcome
from gimbal_hil.proof.bench.faults.rows import Motion

HEADER = ("Row", "Line", "Seen as", "Safe", "Bound", "At rest", "Faster by", "Travel", "Bound", "Verdict")


def matrix_text(found: Sequence[FaultOutcome]) -> str:
    """Every row, then what is to be remembered."""
    rows = [list(HEADER), *map(_cells, found)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(HEADER))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    return "\n".join([*lines, "", *summary(found)])


def matrix_blocks(found: Sequence[FaultOutcome]) -> list[Block]:
    """A section of the results page."""
    return [Heading("Faults"), *(Text(line) for line in summary(found)), Table(HEADER, list(map(_cells, found)))]


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
    return [row.name, str(one.transport), one.cause, *times, *travel, one.problem or "right"]
