"""One self-contained HTML page: text, tables and plotly figures that open without a network.

A page is a title and a tuple of blocks; `render` turns it into text, `write` puts it on disk in one move.
"""

from __future__ import annotations

import html
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from plotly.graph_objects import Figure as PlotlyFigure


@dataclass(frozen=True)
class Heading:
    """A section heading; it also becomes an entry of the page's table of contents."""

    text: str


@dataclass(frozen=True)
class Text:
    """A paragraph of plain words."""

    text: str


@dataclass(frozen=True)
class Callout:
    """The one sentence that matters, set apart; tone is 'good', 'warning' or 'neutral'."""

    text: str
    tone: str = "neutral"


@dataclass(frozen=True)
class Tiles:
    """A row of key figures: (value with unit, what it is)."""

    items: Sequence[tuple[str, str]]


@dataclass(frozen=True)
class Table:
    """A table; the first column is text, numbers are set right. `caption` says what one sees."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""


@dataclass(frozen=True)
class Plot:
    """A plotly figure with a caption that says what one sees."""

    figure: PlotlyFigure
    caption: str = ""


@dataclass(frozen=True)
class Listing:
    """Preformatted text: a file, a difference, a log."""

    text: str
    caption: str = ""


@dataclass(frozen=True)
class Details:
    """Blocks that are folded away until one asks for them."""

    summary: str
    blocks: Sequence[Block]


Block = Heading | Text | Callout | Tiles | Table | Plot | Listing | Details


@dataclass(frozen=True)
class Page:
    """A report: title, one line below it, and blocks in order."""

    title: str
    subtitle: str
    blocks: Sequence[Block]

    def render(self) -> str:
        """The page as one HTML text with everything embedded."""
        plots = any(_has_plot(block) for block in self.blocks)
        headings = [block.text for block in self.blocks if isinstance(block, Heading)]
        contents = "".join(f'<a href="#{_anchor(text)}">{html.escape(text)}</a>' for text in headings)
        body = "\n".join(_render(block) for block in self.blocks)
        script = f"<script>{_plotly_source()}</script><script>{_RESIZE_WHEN_UNFOLDED}</script>" if plots else ""
        return (
            '<!doctype html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" '
            'content="width=device-width">'
            f"<title>{html.escape(self.title)}</title><style>{_STYLE}</style>{script}</head><body>"
            f'<header><div class="mark">gimbal-hil</div><h1>{html.escape(self.title)}</h1>'
            f"<p>{html.escape(self.subtitle)}</p></header>"
            f"{f'<nav>{contents}</nav>' if len(headings) > 2 else ''}<main>{body}</main></body></html>"
        )

    def write(self, path: Path) -> Path:
        """Write the page; a reader sees the old page or the whole new one."""
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_name(path.name + ".part")
        part.write_text(self.render(), encoding="utf-8")
        os.replace(part, path)
        return path


def _has_plot(block: Block) -> bool:
    return isinstance(block, Plot) or (isinstance(block, Details) and any(_has_plot(inner) for inner in block.blocks))


def _anchor(text: str) -> str:
    return "".join(c if c.isalnum() else "-" for c in text.lower()).strip("-")


def _render(block: Block) -> str:
    match block:
        case Heading(text):
            return f'<h2 id="{_anchor(text)}">{html.escape(text)}</h2>'
        case Text(text):
            return f"<p>{html.escape(text)}</p>"
        case Callout(text, tone):
            return f'<div class="callout {html.escape(tone)}">{html.escape(text)}</div>'
        case Tiles(items):
            tiles = "".join(
                f'<div class="tile"><b>{html.escape(value)}</b><span>{html.escape(what)}</span></div>'
                for value, what in items
            )
            return f'<div class="tiles">{tiles}</div>'
        case Table():
            return _table(block)
        case Plot(figure, caption):
            drawn = figure.to_html(
                full_html=False, include_plotlyjs=False, config={"displayModeBar": False, "responsive": True}
            )
            return f"<figure>{drawn}{_caption(caption)}</figure>"
        case Listing(text, caption):
            return f"<figure><pre>{html.escape(text)}</pre>{_caption(caption)}</figure>"
        case Details(summary, blocks):
            inside = "".join(_render(inner) for inner in blocks)
            return f"<details><summary>{html.escape(summary)}</summary>{inside}</details>"


def _table(table: Table) -> str:
    numeric = [
        all(_is_number(row[i]) for row in table.rows if i < len(row) and row[i].strip()) if i else False
        for i in range(len(table.header))
    ]
    mark = [' class="n"' if is_number else "" for is_number in numeric]
    head = "".join(f"<th{mark[i]}>{html.escape(cell)}</th>" for i, cell in enumerate(table.header))
    rows = "".join(
        "<tr>" + "".join(f"<td{mark[i]}>{html.escape(cell)}</td>" for i, cell in enumerate(row)) + "</tr>"
        for row in table.rows
    )
    return (
        f'<figure><div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'
        f"{_caption(table.caption)}</figure>"
    )


def _is_number(text: str) -> bool:
    return text.lstrip("+-−±<>≤≥≈ ")[:1].isdigit() or text in ("–", "—", "-")


def _caption(text: str) -> str:
    return f"<figcaption>{html.escape(text)}</figcaption>" if text else ""


def _plotly_source() -> str:
    from plotly.offline import get_plotlyjs

    return str(get_plotlyjs())


#: a figure that was folded away did not know its width
_RESIZE_WHEN_UNFOLDED = "document.addEventListener('toggle',()=>window.dispatchEvent(new Event('resize')),true)"

_STYLE = """
:root{--ink:#1c2530;--soft:#5b6775;--line:#dfe4ea;--accent:#1f6f8b;--paper:#fff;--good:#e8f5ec;--warning:#fdf3e1;
  --neutral:#eef4f8}
*{box-sizing:border-box}
body{margin:0;color:var(--ink);background:#f5f7f9;
  font:16px/1.55 system-ui,-apple-system,"Segoe UI",Roboto,"DejaVu Sans",sans-serif}
header{background:#17324a;color:#fff;padding:28px max(24px,calc(50vw - 540px)) 24px}
header h1{margin:2px 0 4px;font-size:28px;font-weight:650}
header p{margin:0;color:#cfdae4}
.mark{font-size:12px;letter-spacing:.14em;text-transform:uppercase;color:#8fb4cd}
nav{position:sticky;top:0;z-index:5;background:var(--paper);border-bottom:1px solid var(--line);
  padding:8px max(24px,calc(50vw - 540px));display:flex;gap:18px;flex-wrap:wrap;font-size:14px}
nav a{color:var(--accent);text-decoration:none}
main{max-width:1080px;margin:18px auto 60px;padding:12px 32px 36px;background:var(--paper);
  border:1px solid var(--line);border-radius:8px}
h2{font-size:20px;margin:34px 0 8px;padding-top:6px;scroll-margin-top:48px}
p{max-width:76ch;margin:8px 0}
figure{margin:14px 0 22px}
figcaption{color:var(--soft);font-size:14px;max-width:84ch;margin-top:6px}
.callout{border-left:4px solid var(--accent);background:var(--neutral);padding:12px 16px;margin:16px 0;
  border-radius:0 6px 6px 0;font-size:17px}
.callout.good{background:var(--good);border-color:#2f8f57}
.callout.warning{background:var(--warning);border-color:#c9861a}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(150px,1fr));gap:12px;margin:16px 0}
.tile{border:1px solid var(--line);border-radius:6px;padding:10px 14px}
.tile b{display:block;font-size:21px;font-weight:640}
.tile span{color:var(--soft);font-size:14px}
.scroll{overflow-x:auto}
table{border-collapse:collapse;font-size:14px;min-width:50%}
th{text-align:left;font-weight:640;border-bottom:2px solid var(--line);padding:5px 12px 5px 0;white-space:nowrap}
td{border-bottom:1px solid var(--line);padding:4px 12px 4px 0;vertical-align:top}
.n{text-align:right;white-space:nowrap;font-variant-numeric:tabular-nums}
pre{background:#f3f5f8;border:1px solid var(--line);border-radius:6px;padding:12px 14px;overflow-x:auto;
  font:13px/1.45 ui-monospace,"DejaVu Sans Mono",monospace}
details{border:1px solid var(--line);border-radius:6px;padding:8px 14px;margin:12px 0}
summary{cursor:pointer;font-weight:600}
"""
