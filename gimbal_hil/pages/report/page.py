"""One self-contained HTML page: text, tables and figures that open without a network.

A page is a title and a tuple of blocks; `render` turns it into text, `write` puts it on disk in one move. It is under a
megabyte: the library that draws lies in it compressed, and so do the figures, which are drawn when one comes near them
(docs/decisions/0120-embed-plotlys-basic-bundle-compressed-in-each-page.md).
"""

from __future__ import annotations

import html
import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.resources import files
from itertools import count
from pathlib import Path

from gimbal_hil.pages.antenna import ANTENNA_SCRIPT, MOTION_SCRIPT
from gimbal_hil.pages.plots import Drawing
from gimbal_hil.pages.report.blocks import (
    Block,
    Callout,
    Details,
    Heading,
    Listing,
    MovingAntenna,
    Plot,
    Table,
    Text,
    Tiles,
    blocks_in,
    plots_in,
)
from gimbal_hil.pages.report.figures_packed import drawing_library, packed
from gimbal_hil.pages.report.made import Made, made_here

#: headings from which on a page has a table of contents
_CONTENTS_FROM = 3
#: of a torque: a line that ends in it reads as newtons
_NEWTON_METRE = "N m"
#: columns up to which a table has room beside each other on a phone
_COLUMNS_OF_A_PHONE = 3


@dataclass(frozen=True)
class Page:
    """A report: title, one line below it, and blocks in order."""

    title: str
    subtitle: str
    blocks: Sequence[Block]

    def render(self, made: Made | None = None) -> str:
        """The page as one HTML text with everything embedded; `made` in the place of this process and this second."""
        made = made or made_here()
        figures = [plot.figure for plot in plots_in(self.blocks)]
        headings = [block.text for block in self.blocks if isinstance(block, Heading)]
        contents = "".join(f'<a href="#{_anchor(text)}">{html.escape(text)}</a>' for text in headings)
        numbers = count()
        body = "\n".join(_render(block, numbers) for block in self.blocks)
        navigation = f'<nav aria-label="Contents">{contents}</nav>' if len(headings) >= _CONTENTS_FROM else ""
        return (
            '<!doctype html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" '
            'content="width=device-width, initial-scale=1"><meta name="color-scheme" content="light dark">'
            f"<title>{html.escape(self.title)}</title><style>{_static('page.css')}</style></head><body>"
            f'<header><div class="mark">gimbal-hil</div><h1>{html.escape(self.title)}</h1>'
            f"<p>{html.escape(self.subtitle)}</p></header>"
            f"{navigation}<main>{body}</main>{_foot(made)}{_script(figures)}{_moving(self.blocks)}</body></html>"
        )

    def write(self, path: Path) -> Path:
        """Write the page; a reader sees the old page or the whole new one."""
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_name(path.name + ".part")
        # a path in it may be of any bytes
        part.write_text(self.render(), encoding="utf-8", errors="backslashreplace")
        os.replace(part, path)
        return path


def _static(name: str) -> str:
    return (files("gimbal_hil.pages.report") / "static" / name).read_text(encoding="utf-8")


def _script(figures: Sequence[Drawing]) -> str:
    if not figures:
        return ""
    return (
        "<noscript><p>The figures of this page are drawn by a script.</p></noscript>"
        f'<script type="text/plain" id="packed:library">{drawing_library()}</script>'
        f'<script type="text/plain" id="packed:figures">{packed(figures)}</script>'
        f"<script>{_static('page.js')}</script>"
    )


def _moving(blocks: Sequence[Block]) -> str:
    if not any(isinstance(block, MovingAntenna) for block in blocks_in(blocks)):
        return ""
    begin = 'for (const one of document.querySelectorAll("figure.motion")) motion_player(one);'
    return f'<script>"use strict";\n{ANTENNA_SCRIPT}{MOTION_SCRIPT}{begin}</script>'


def _foot(made: Made) -> str:
    return (
        f'<footer>Made <time datetime="{html.escape(made.at_utc)}">{html.escape(made.at_utc)}</time> by gimbal-hil '
        f"{html.escape(made.version)} with<pre>{html.escape(made.command)}</pre></footer>"
    )


def _anchor(text: str) -> str:
    """Name of a heading's place: letters, figures and dashes, so never that of what is packed into the page."""
    return "".join(c if c.isalnum() else "-" for c in text.lower()).strip("-")


def _render(block: Block, numbers: Iterator[int]) -> str:
    match block:
        case Heading(text):
            return f'<h2 id="{_anchor(text)}">{html.escape(text)}</h2>'
        case Text(text):
            return f"<p>{html.escape(text)}</p>"
        case Callout(text, tone, more):
            then = f"<small>{html.escape(more)}</small>" if more else ""
            return f'<div class="callout {html.escape(tone)}">{html.escape(text)}{then}</div>'
        case Tiles(items):
            tiles = "".join(
                f'<div class="tile"><b>{html.escape(_unbroken(value))}</b><span>{html.escape(what)}</span></div>'
                for value, what in items
            )
            return f'<div class="tiles">{tiles}</div>'
        case Table():
            return _table(block)
        case Plot():
            return _plot(block, next(numbers))
        case MovingAntenna():
            return _motion(block)
        case Listing(text, caption):
            return f'<figure><pre tabindex="0">{html.escape(text)}</pre>{_caption(caption)}</figure>'
        case Details(summary, blocks):
            inside = "".join(_render(inner, numbers) for inner in blocks)
            return f"<details><summary>{html.escape(summary)}</summary>{inside}</details>"


def _plot(plot: Plot, number: int) -> str:
    """The place of a figure, as high as the figure will be: what stands below does not jump when it is drawn."""
    title = plot.figure.layout["title"]["text"]
    height = int(plot.figure.layout.get("height", 400))
    said = " ".join(part for part in (title, plot.caption) if part)
    # a figure's title is the page's, so that no legend can lie over it
    above = f"<h3>{html.escape(title)}</h3>" if title else ""
    return (
        f'<figure>{above}{_legend(plot)}<div class="plot" data-figure="{number}" '
        f'style="height:{height}px" role="img" aria-label="{html.escape(said)}"></div>'
        f'<div class="below">{_caption(plot.caption)}<span class="save" hidden><button type="button">SVG</button>'
        '<button type="button">PDF</button></span></div>'
        "</figure>"
    )


def _motion(motion: MovingAntenna) -> str:
    """A canvas with its data, a player and a switch for each model."""
    told = {
        "title": motion.title,
        "names": motion.names,
        "time_s": _short(motion.time_s, 3),
        "measured": [_short(column, 5) for column in motion.measured],
        "models": [
            {"name": one.name, "position": [_short(column, 5) for column in one.position]} for one in motion.models
        ],
    }
    # as text of a script element: nothing in it may look like the element's end
    data = json.dumps(told, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    switches = "".join(
        f'<button type="button" aria-pressed="false">{html.escape(one.name)}</button>' for one in motion.models
    )
    return (
        f'<figure class="motion"><h3>{html.escape(motion.title)}</h3><canvas role="img" '
        f'aria-label="{html.escape(motion.title)}"></canvas><div class="player"><button type="button">Play</button>'
        f'<input type="range" min="0" max="{float(motion.time_s[-1]):.3f}" step="any" value="0" aria-label="time">'
        f"{switches if len(motion.models) > 1 else ''}</div><output></output>{_caption(motion.caption)}"
        f'<script type="application/json">{data}</script></figure>'
    )


def _short(values: Sequence[float], digits: int) -> list[float]:
    return [round(float(value), digits) for value in values]


def _legend(plot: Plot) -> str:
    """Names of what is drawn, each a switch; a figure of one thing needs none."""
    told = [trace["name"] for trace in plot.figure.data if trace.get("name") and trace.get("showlegend", True)]
    names = list(dict.fromkeys(told))
    buttons = [f'<button type="button" aria-pressed="true">{html.escape(name)}</button>' for name in names]
    return f'<div class="legend">{"".join(buttons) if len(names) > 1 else ""}</div>'


def _unbroken(value: str) -> str:
    """A key figure whose unit stays on one line."""
    return value.replace(_NEWTON_METRE, _NEWTON_METRE.replace(" ", "\u00a0"))


def _table(table: Table) -> str:
    numeric = [
        all(_is_number(row[i]) for row in table.rows if i < len(row) and row[i].strip()) if i else False
        for i in range(len(table.header))
    ]
    mark = [' class="n"' if is_number else "" for is_number in numeric]
    head = "".join(f'<th scope="col"{mark[i]}>{html.escape(cell)}</th>' for i, cell in enumerate(table.header))
    # on a phone each row of a wide table stands as lines of its own, each with the column's title before it
    wide = len(table.header) > _COLUMNS_OF_A_PHONE
    title = [f' data-title="{html.escape(cell)}"' if wide else "" for cell in table.header]
    rows = "".join(
        "<tr>" + "".join(f"<td{mark[i]}{title[i]}>{html.escape(cell)}</td>" for i, cell in enumerate(row)) + "</tr>"
        for row in table.rows
    )
    kind = ' class="wide"' if wide else ""
    return (
        f'<figure><div class="scroll" tabindex="0"><table{kind}><thead><tr>{head}</tr></thead><tbody>{rows}</tbody>'
        f"</table></div>{_caption(table.caption)}</figure>"
    )


def _is_number(text: str) -> bool:
    return text.lstrip("+-−±<>≤≥≈ ")[:1].isdigit() or text in ("–", "—", "-")


def _caption(text: str) -> str:
    return f"<figcaption>{html.escape(text)}</figcaption>" if text else ""
