"""The common look of every figure: one template, one palette, axes with units."""

from __future__ import annotations

from collections.abc import Sequence

import plotly.graph_objects as go
from plotly.subplots import make_subplots

#: measured, model, reference, second axis, warning
MEASURED, MODEL, REFERENCE, SECOND, ALERT = ("#1f6f8b", "#d1603d", "#8a94a0", "#6a4c93", "#b3261e")
#: of the first axis and of the second
AXIS_COLOURS = ("#1f6f8b", "#d1603d")

_LAYOUT = dict(
    template="plotly_white",
    font=dict(family="system-ui, Segoe UI, Roboto, DejaVu Sans, sans-serif", size=13, color="#1c2530"),
    # a line for the title and one below it for the legend; a page has both beside the figure (report/static/page.js)
    margin=dict(l=70, r=24, t=72, b=52),
    legend=dict(orientation="h", yanchor="bottom", y=1.02, xanchor="left", x=0.0),
    hovermode="x unified",
    colorway=(MEASURED, MODEL, SECOND, "#4a8c5c", "#b8860b", REFERENCE),
)


def figure(title: str, x_title: str, y_title: str, height: int = 380) -> go.Figure:
    """An empty figure in the house style; titles carry units in brackets."""
    drawn = go.Figure()
    drawn.update_layout(title=_title(title), height=height, **_LAYOUT)
    drawn.update_xaxes(title=x_title, zeroline=False, showline=True, linecolor="#c8d0d8", automargin=True)
    drawn.update_yaxes(title=y_title, zerolinecolor="#dfe4ea", showline=True, linecolor="#c8d0d8", automargin=True)
    return drawn


def stacked(
    titles: Sequence[str], x_title: str, y_titles: Sequence[str], height_each: int = 210, title: str = ""
) -> go.Figure:
    """Panels above each other that share one x axis, in the house style; `titles` of the panels, `title` of all."""
    drawn = make_subplots(
        rows=len(titles),
        cols=1,
        shared_xaxes=True,
        vertical_spacing=0.08 / max(1, len(titles) - 1) + 0.03,
        subplot_titles=list(titles),
    )
    drawn.update_layout(title=_title(title), height=height_each * len(titles) + 80, **_LAYOUT)
    drawn.update_annotations(font=dict(size=13), x=0.0, xanchor="left")
    for row, y_title in enumerate(y_titles, start=1):
        drawn.update_yaxes(title=y_title, row=row, col=1, zerolinecolor="#dfe4ea", showline=True, linecolor="#c8d0d8")
    drawn.update_xaxes(showline=True, linecolor="#c8d0d8", zeroline=False, automargin=True)
    drawn.update_yaxes(automargin=True)
    drawn.update_xaxes(title=x_title, row=len(titles), col=1)
    return drawn


def figure_of_panels(x_titles: Sequence[str], y_title: str, height_each: int, title: str) -> go.Figure:
    """Panels above each other, each with an x axis of its own, of one quantity with one y axis."""
    count = len(x_titles)
    drawn = make_subplots(rows=count, cols=1, shared_yaxes="all", vertical_spacing=0.26 / max(1, count))
    drawn.update_layout(title=_title(title), height=height_each * count + 80, **_LAYOUT | dict(hovermode="closest"))
    drawn.update_xaxes(showline=True, linecolor="#c8d0d8", zeroline=False, automargin=True)
    drawn.update_yaxes(title=y_title, zerolinecolor="#dfe4ea", showline=True, linecolor="#c8d0d8", automargin=True)
    for row, x_title in enumerate(x_titles, start=1):
        drawn.update_xaxes(title=x_title, row=row, col=1)
    return drawn


def _title(text: str) -> dict[str, object]:
    at_the_top = dict(x=0.0, xanchor="left", y=1.0, yref="container", yanchor="top", pad=dict(t=12, l=12))
    return dict(text=text, font=dict(size=15), **at_the_top)


def thinned(count: int, most: int = 4000) -> slice:
    """A slice that leaves at most `most` of `count` samples, so that a page stays light."""
    return slice(None, None, max(1, -(-count // most)))
