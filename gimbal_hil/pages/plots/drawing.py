"""A figure: traces and a layout as plotly.js takes them, and nothing else.

The pages carry the drawing library themselves, so the Python package `plotly` (39 MB) is not needed to make one. Where
it is installed, `plotly.graph_objects.Figure(figure.to_dict())` is the same figure; the tests ask that of every figure
that they put on a page.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from firmware_protocol.json_object import Json


class Drawing:
    """One or more panels above each other, counted from 1; a row that is not given is all of them, or the first.

    Names and values of properties are those of plotly.js (https://plotly.com/javascript/reference), groups of them as
    dictionaries.
    """

    def __init__(self, panels: int = 1) -> None:
        self.panels = panels
        self.data: list[Json] = []
        self.layout: Json = {"title": {"text": ""}, "shapes": [], "annotations": []}
        for row in range(1, panels + 1):
            self.layout |= {f"xaxis{_place(row)}": {}, f"yaxis{_place(row)}": {}}

    def add_scatter(self, row: int = 1, **properties: object) -> None:
        """Lines or points."""
        self._add("scatter", row, properties)

    def add_bar(self, row: int = 1, **properties: object) -> None:
        """Bars."""
        self._add("bar", row, properties)

    def add_hline(self, y: float, row: int = 1, **line: Any) -> None:
        """A line at a height from one side of a panel to the other."""
        place = _place(row)
        ends: Json = {"x0": 0, "x1": 1, "xref": f"x{place} domain", "y0": y, "y1": y, "yref": f"y{place}"}
        self.layout["shapes"].append({"type": "line", "line": line, **ends})

    def add_vline(self, x: float, row: int = 1, **line: Any) -> None:
        """A line from the bottom of a panel to its top."""
        place = _place(row)
        ends: Json = {"x0": x, "x1": x, "xref": f"x{place}", "y0": 0, "y1": 1, "yref": f"y{place} domain"}
        self.layout["shapes"].append({"type": "line", "line": line, **ends})

    def add_annotation(self, text: str, **properties: Any) -> None:
        """Words in the picture, without an arrow."""
        self.layout["annotations"].append({"text": text, "showarrow": False, **properties})

    def update_layout(self, **properties: object) -> None:
        """Set properties of the whole figure; what is in a group already and not named stays."""
        _merge(self.layout, properties)

    def update_xaxes(self, row: int | None = None, **properties: object) -> None:
        """Set properties of the x axes."""
        self._update("xaxis", row, properties)

    def update_yaxes(self, row: int | None = None, **properties: object) -> None:
        """Set properties of the y axes."""
        self._update("yaxis", row, properties)

    def to_dict(self) -> Json:
        """Traces and layout, arrays as they were given; what `plotly.graph_objects.Figure` takes."""
        return {"data": [dict(trace) for trace in self.data], "layout": dict(self.layout)}

    def _add(self, kind: str, row: int, properties: Mapping[str, object]) -> None:
        place = _place(row)
        self.data.append({"type": kind, "xaxis": f"x{place}", "yaxis": f"y{place}", **properties})

    def _update(self, axis: str, row: int | None, properties: Mapping[str, Any]) -> None:
        for one in range(1, self.panels + 1) if row is None else (row,):
            _merge(self.layout[f"{axis}{_place(one)}"], properties)


def _place(row: int) -> str:
    return "" if row == 1 else str(row)


def _merge(into: Json, properties: Mapping[str, Any]) -> None:
    for name, value in properties.items():
        if name == "title" and isinstance(value, str):
            value = {"text": value}
        if isinstance(value, Mapping):
            _merge(into.setdefault(name, {}), value)
        else:
            into[name] = value
