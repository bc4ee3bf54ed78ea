"""Laws that were told, drawn beside their truth: `python -m tests.laws.pictures ROWS.jsonl OUT.svg`."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import numpy as np

from tests.laws.kinds import KINDS

#: size of a panel and the space around its picture, in pixels
_WIDE, _HIGH, _LEFT, _RIGHT, _TOP, _BELOW = 300, 215, 52, 10, 44, 34
_ACROSS = 3
_TRUTH, _CURVE, _FORMULA = "#9aa5b1", "#1f6feb", "#c8372d"
_UNITS = {"position": "rad", "rate": "rad/s", "speed": "rad/s", "torque": "N m", "hangs_back": "rad"}


def truth_of(row: dict[str, Any], told: tuple[str, tuple[str, ...], bool], x: np.ndarray) -> np.ndarray | None:
    """What is hidden, over the variable that it was told over; None where its kind has no law of one variable."""
    law, numbers = KINDS[row["kind"]].truth, row["truth"]["row"]
    if law is None or len(told[1]) == 2:
        return None
    if told == ("torque", ("rate",), False):
        return -np.sign(x) * law(numbers, np.abs(x)) if KINDS[row["kind"]].right[0][0] == "friction" else None
    if told[2]:
        return -law(numbers, x)
    return law(numbers, x)


def panel(row: dict[str, Any], at: tuple[int, int]) -> str:
    """One law: grey what is hidden, blue the curve with its band, red and dashed the formula."""
    law = max(row["laws"], key=lambda one: one["gain"])
    told = (law["told"][0], tuple(law["told"][1]), law["told"][2])
    x, y, low, high = (np.array(part) for part in law["drawn"][0])
    lines = [(_CURVE, 1.6, "", y)]
    truth = truth_of(row, told, x)
    if truth is not None:
        # a level is the friction's or an offset's as much as the law's
        lines = [(_TRUTH, 5.0, "", truth + float(np.median(y - truth))), *lines]
    if law["drawn_formula"]:
        lines.append((_FORMULA, 1.4, "5 3", np.array(law["drawn_formula"][0])))
    most = max(float(np.max(line)) for *_, line in lines)
    least = min(float(np.min(line)) for *_, line in lines)
    most, least = (most + 0.06 * (most - least) + 1e-12, least - 0.06 * (most - least) - 1e-12)

    def place(values: np.ndarray) -> str:
        across = _LEFT + (x - x[0]) / (x[-1] - x[0]) * (_WIDE - _LEFT - _RIGHT)
        down = _TOP + (most - np.clip(values, least, most)) / (most - least) * (_HIGH - _TOP - _BELOW)
        return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, down, strict=True))

    band = place(high) + " " + " ".join(reversed(place(low).split(" ")))
    drawn = [f'<polygon points="{band}" fill="{_CURVE}" opacity="0.15"/>']
    drawn += [
        f'<polyline points="{place(line)}" fill="none" stroke="{colour}" stroke-width="{width}"'
        f' stroke-dasharray="{dash}"/>'
        for colour, width, dash, line in lines
    ]
    said = law["phrase"] or "a curve"
    over, worst = told[1][0], int(np.argmax(row["before"]))
    words = [
        (
            8,
            15,
            "start",
            12,
            f"{row['kind'].replace('_', ' ')}: {row['before'][worst]:.4g} to {row['left'][worst]:.2f} floors",
        ),
        (8, 30, "start", 10, said),
        (_LEFT - 4, _TOP + 8, "end", 9, f"{most:.2g}"),
        (_LEFT - 4, _HIGH - _BELOW, "end", 9, f"{least:.2g}"),
        (_LEFT, _HIGH - _BELOW + 12, "start", 9, f"{x[0]:.2g}"),
        (_WIDE - _RIGHT, _HIGH - _BELOW + 12, "end", 9, f"{x[-1]:.2g}"),
        (0.5 * (_WIDE + _LEFT), _HIGH - 8, "middle", 9, f"{over} [{_UNITS.get(over, '')}], {told[0]} [N m]"),
    ]
    drawn += [
        f'<text x="{a:.0f}" y="{b:.0f}" text-anchor="{anchor}" font-size="{size}">{escape(text)}</text>'
        for a, b, anchor, size, text in words
    ]
    frame = (
        f'<rect x="{_LEFT}" y="{_TOP}" width="{_WIDE - _LEFT - _RIGHT}" height="{_HIGH - _TOP - _BELOW}" fill="none"'
        ' stroke="#d0d7de"/>'
    )
    return f'<g transform="translate({at[0] * _WIDE},{at[1] * _HIGH})">{frame}{"".join(drawn)}</g>'


def _is_surface(row: dict[str, Any]) -> bool:
    """Whether the law that takes most has two variables: one cut through it says little."""
    return len(max(row["laws"], key=lambda one: one["gain"])["told"][1]) == 2


def picture(rows: list[dict[str, Any]]) -> str:
    """All panels as one SVG."""
    told = [row for row in rows if row.get("laws") and row["kind"] in KINDS and not _is_surface(row)]
    high = -(-len(told) // _ACROSS)
    panels = [panel(row, (k % _ACROSS, k // _ACROSS)) for k, row in enumerate(told)]
    size = f'width="{_ACROSS * _WIDE}" height="{high * _HIGH}" viewBox="0 0 {_ACROSS * _WIDE} {high * _HIGH}"'
    ground = '<rect width="100%" height="100%" fill="#ffffff"/>'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif" fill="#1c2530">{ground}'
    return head + "\n".join(panels) + "</svg>\n"


def main(arguments: list[str]) -> int:
    """Rows of one file or several, the last argument is the picture."""
    rows = [json.loads(line) for name in arguments[:-1] for line in Path(name).read_text().splitlines()]
    Path(arguments[-1]).write_text(picture(rows), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
