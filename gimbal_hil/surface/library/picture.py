"""A figure that stands by itself: in a notebook, or as a page."""

from __future__ import annotations

import html
from pathlib import Path
from typing import Self

from firmware_protocol.errors import BadInputError
from gimbal_hil.pages.plots import Drawing
from gimbal_hil.pages.report import Page, Plot

#: of a page beside its figure: head, title, buttons, foot
_AROUND_PX = 330


class Picture(Drawing):
    """A figure of the library. A notebook shows it; `data` and `layout` are what plotly.js takes."""

    _title = ""

    @classmethod
    def of(cls, figure: Drawing, title: str) -> Self:
        """The same figure; `title` is that of its page."""
        found = cls(figure.panels)
        found.data, found.layout, found._title = figure.data, figure.layout, title
        return found

    def write(self, path: Path | str) -> Path:
        """A page (.html) of this figure alone, which opens without a network; answers its path. Path or text;
        BadInputError for another kind of file.
        """
        path = Path(path)
        if path.suffix not in (".html", ".htm"):
            raise BadInputError(
                str(path), f"is no page: {path.suffix or 'no ending'} cannot be written", "a name that ends in .html"
            )
        return self._page().write(path)

    def _page(self) -> Page:
        return Page(self._title, "", [Plot(self)])

    def _repr_html_(self) -> str:
        page = html.escape(self._page().render(), quote=True)
        height, title = int(self.layout["height"]) + _AROUND_PX, html.escape(self._title, quote=True)
        return f'<iframe srcdoc="{page}" style="width:100%;height:{height}px;border:0" title="{title}"></iframe>'
