"""A figure that stands by itself: in a notebook, or as a page."""

from __future__ import annotations

import html
from pathlib import Path
from typing import Self

from firmware_protocol.errors import BadInputError
from gimbal_hil.pages.plots import PICTURE_ENDINGS, Drawing, write_picture
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
        """This figure alone, by the ending: a page that opens without a network (.html), or a picture (.svg, .pdf,
        .png; needs the extra `pictures`). Path or text; answers the path. BadInputError for another kind of file.
        """
        path = Path(path)
        if path.suffix in (".html", ".htm"):
            return self._page().write(path)
        if path.suffix not in PICTURE_ENDINGS:
            endings = ", ".join((".html", *PICTURE_ENDINGS))
            raise BadInputError(str(path), f"has the ending {path.suffix or 'none'}", f"a name with one of {endings}")
        return write_picture(self, path, self._title)

    def _page(self) -> Page:
        return Page(self._title, "", [Plot(self)])

    def _repr_html_(self) -> str:
        page = html.escape(self._page().render(), quote=True)
        height, title = int(self.layout["height"]) + _AROUND_PX, html.escape(self._title, quote=True)
        return f'<iframe srcdoc="{page}" style="width:100%;height:{height}px;border:0" title="{title}"></iframe>'
