"""How much a tool's probabilities are worth, drawn: what it said against how often that was right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from xml.sax.saxutils import escape

import numpy as np

from tests.benchmarks.naming.scoring import Score

#: names that were told with a probability in one of these count together
EDGES = (0.0, 0.25, 0.5, 0.75, 0.9, 1.0)
_SIDE, _LEFT, _TOP, _GAP, _ACROSS = 150, 34, 38, 18, 5
_LINE, _DOT, _TEXT = "#9aa5b1", "#1f6feb", "#57606a"


def reliability(scores: Sequence[Score]) -> list[tuple[float, float, int]]:
    """Mean probability, share that was right and count, of each bin that has names."""
    told = np.array([pair for one in scores for pair in one.told], dtype=float).reshape(-1, 2)
    place = np.clip(np.searchsorted(EDGES, told[:, 0], side="left") - 1, 0, len(EDGES) - 2)
    parts = [told[place == k] for k in range(len(EDGES) - 1)]
    return [(float(part[:, 0].mean()), float(part[:, 1].mean()), len(part)) for part in parts if len(part)]


def drawn(tools: Mapping[str, Sequence[Score]]) -> str:
    """A panel for each tool, as SVG; on the line probabilities are what they say, below it the tool is too sure."""
    wide, high = _LEFT + _SIDE + _GAP, _TOP + _SIDE + 30
    rows = -(-len(tools) // _ACROSS)
    size = f"{wide * min(len(tools), _ACROSS)} {high * rows + 8}"
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size}" font-family="sans-serif">']
    parts.append('<rect width="100%" height="100%" fill="#ffffff"/>')
    for k, (tool, scores) in enumerate(tools.items()):
        parts.append(f'<g transform="translate({k % _ACROSS * wide},{k // _ACROSS * high})">{_panel(tool, scores)}</g>')
    return "\n".join([*parts, "</svg>"]) + "\n"


def _panel(tool: str, scores: Sequence[Score]) -> str:
    bins = reliability(scores)
    bottom, right = _TOP + _SIDE, _LEFT + _SIDE
    words = [
        (_LEFT, 16, "start", 12, tool),
        (_LEFT, 30, "start", 10, f"{sum(count for *_, count in bins)} names in {len(scores)} cases"),
        (_LEFT - 4, _TOP + 8, "end", 9, "all"),
        (_LEFT - 4, bottom, "end", 9, "none"),
        (_LEFT, bottom + 12, "start", 9, "0"),
        (right, bottom + 12, "end", 9, "1"),
        (_LEFT + _SIDE / 2, bottom + 12, "middle", 9, "said; upwards: right"),
    ]
    drawn = [
        f'<rect x="{_LEFT}" y="{_TOP}" width="{_SIDE}" height="{_SIDE}" fill="none" stroke="#d0d7de"/>',
        f'<line x1="{_LEFT}" y1="{bottom}" x2="{right}" y2="{_TOP}" stroke="{_LINE}" stroke-dasharray="4 3"/>',
    ]
    drawn += [
        f'<circle cx="{_LEFT + said * _SIDE:.1f}" cy="{bottom - hit * _SIDE:.1f}" r="{2.5 + 1.5 * np.log10(count):.1f}"'
        f' fill="{_DOT}" fill-opacity="0.75"/>'
        for said, hit, count in bins
    ]
    drawn += [
        f'<text x="{x}" y="{y}" text-anchor="{anchor}" font-size="{size}" fill="{_TEXT}">{escape(text)}</text>'
        for x, y, anchor, size, text in words
    ]
    return "".join(drawn)
