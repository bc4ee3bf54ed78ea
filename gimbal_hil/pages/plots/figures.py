"""The common look of every figure: one template, one palette, axes with units."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.json_object import Json
from gimbal_hil.pages.plots.drawing import Drawing

#: measured, model, reference, second axis, warning
MEASURED, MODEL, REFERENCE, SECOND, ALERT = ("#1f6f8b", "#d1603d", "#8a94a0", "#6a4c93", "#b3261e")
#: of the first axis and of the second
AXIS_COLOURS = ("#1f6f8b", "#d1603d")

#: noise floors up to which an axis begins at zero
_LINEAR_UP_TO = 50.0
#: decades up to which a logarithmic axis has room for two and five
_DECADES_WITH_DIGITS = 4.0

_LINES = dict(gridcolor="#ebf0f8", ticks="", zerolinewidth=2, title=dict(standoff=15))
_DARK = dict(color="#2a3f5f")
_TEMPLATE = dict(
    layout=dict(
        xaxis=_LINES,
        yaxis=_LINES,
        autotypenumbers="strict",
        hoverlabel=dict(align="left"),
        paper_bgcolor="white",
        plot_bgcolor="white",
    ),
    data=dict(bar=[dict(type="bar", error_x=_DARK, error_y=_DARK, marker=dict(line=dict(color="white", width=0.5)))]),
)
_LAYOUT = dict(
    template=_TEMPLATE,
    font=dict(family="system-ui, Segoe UI, Roboto, DejaVu Sans, sans-serif", size=13, color="#1c2530"),
    # a line for the title and one below it for the legend; a page has both beside the figure (report/static/page.js)
    margin=dict(l=70, r=24, t=72, b=52),
    legend=dict(orientation="h", yanchor="bottom", y=1.02, xanchor="left", x=0.0),
    hovermode="x unified",
    colorway=(MEASURED, MODEL, SECOND, "#4a8c5c", "#b8860b", REFERENCE),
)


def figure(title: str, x_title: str, y_title: str, height: int = 380) -> Drawing:
    """An empty figure in the house style; titles carry units in brackets."""
    drawn = _panels(1, title, height, 0.0)
    drawn.update_xaxes(title=x_title, zeroline=False)
    drawn.update_yaxes(title=y_title)
    return drawn


def stacked(
    titles: Sequence[str], x_title: str, y_titles: Sequence[str], height_each: int = 210, title: str = ""
) -> Drawing:
    """Panels above each other that share one x axis, in the house style; `titles` of the panels, `title` of all."""
    count = len(titles)
    drawn = _panels(count, title, height_each * count + 80, 0.08 / max(1, count - 1) + 0.03)
    drawn.update_xaxes(zeroline=False)
    for row, (panel, y_title) in enumerate(zip(titles, y_titles, strict=True), start=1):
        if panel:
            at_its_top = dict(x=0.0, xanchor="left", y=1.0, yanchor="bottom", font=dict(size=13))
            place = "" if row == 1 else row
            drawn.add_annotation(panel, xref="paper", yref=f"y{place} domain", **at_its_top)
        drawn.update_yaxes(row, title=y_title)
        if row < count:
            drawn.update_xaxes(row, matches=f"x{count}", showticklabels=False)
    drawn.update_xaxes(count, title=x_title)
    return drawn


def figure_of_panels(x_titles: Sequence[str], y_title: str, height_each: int, title: str) -> Drawing:
    """Panels above each other, each with an x axis of its own, of one quantity with one y axis."""
    count = len(x_titles)
    drawn = _panels(count, title, height_each * count + 80, 0.26 / max(1, count))
    drawn.update_layout(hovermode="closest")
    drawn.update_xaxes(zeroline=False)
    drawn.update_yaxes(title=y_title)
    for row, x_title in enumerate(x_titles, start=1):
        drawn.update_xaxes(row, title=x_title)
        if row < count:
            drawn.update_yaxes(row, matches=f"y{count}")
    return drawn


def logarithm(values: Iterable[float | None]) -> Json:
    """Properties of a logarithmic axis for these values: one, two and five of every decade written out, and of more
    than four decades the powers of ten alone.
    """
    sizes = [value for value in values if value is not None and math.isfinite(value) and value > 0.0]
    low, high = (math.log10(end) for end in (min(sizes, default=1.0), max(sizes, default=1.0)))
    digits = (1,) if high - low > _DECADES_WITH_DIGITS else (1, 2, 5)
    ticks = [
        float(f"{digit}e{decade}") for decade in range(math.floor(low) - 1, math.ceil(high) + 2) for digit in digits
    ]
    return dict(type="log", tickvals=ticks, ticktext=[f"{tick:g}" for tick in ticks])


def in_floors(drawn: Drawing, values: Sequence[float]) -> None:
    """An upright axis for sizes in noise floors, with a line at one floor: from zero, so that a bar is as long as it is
    large, and logarithmic only where the largest would hide the smallest.
    """
    most = max([value for value in values if math.isfinite(value)], default=1.0)
    logarithmic = most > _LINEAR_UP_TO
    drawn.add_hline(y=1.0, color=ALERT, width=1.5)
    # on a logarithmic axis annotations stand at the logarithm
    at = dict(x=1.0, xref="paper", xanchor="right", y=0.0 if logarithmic else 1.0, yanchor="bottom")
    drawn.add_annotation("noise floor", **at)
    if logarithmic:
        drawn.update_yaxes(**logarithm(values))
    else:
        drawn.update_yaxes(range=[0.0, 1.12 * max(most, 1.2)])


def _panels(count: int, title: str, height: int, space: float) -> Drawing:
    """`count` panels of equal height with a space between them, a share of the whole."""
    drawn = Drawing(count)
    drawn.update_layout(title=_title(title), height=height, **_LAYOUT)
    drawn.update_xaxes(showline=True, linecolor="#c8d0d8", automargin=True)
    drawn.update_yaxes(showline=True, linecolor="#c8d0d8", zerolinecolor="#dfe4ea", automargin=True)
    if count > 1:
        share = (1.0 - space * (count - 1)) / count
        for row in range(1, count + 1):
            place, bottom = "" if row == 1 else row, (count - row) * (share + space)
            drawn.update_xaxes(row, anchor=f"y{place}", domain=[0.0, 1.0])
            drawn.update_yaxes(row, anchor=f"x{place}", domain=[bottom, bottom + share])
    return drawn


def _title(text: str) -> dict[str, object]:
    at_the_top = dict(x=0.0, xanchor="left", y=1.0, yref="container", yanchor="top", pad=dict(t=12, l=12))
    return dict(text=text, font=dict(size=15), **at_the_top)


def thinned(count: int, most: int = 4000) -> slice:
    """A slice that leaves at most `most` of `count` samples, so that a page stays light."""
    return slice(None, None, max(1, -(-count // most)))


def peaks_kept(values: NDArray[np.float64], most: int = 4000) -> NDArray[np.int64]:
    """Which of the samples (n,) to draw, at most about `most`, so that a page stays light and no peak is lost: the
    smallest and the largest of each stretch.
    """
    if len(values) <= most:
        return np.arange(len(values))
    starts = np.linspace(0, len(values), most // 2, endpoint=False).astype(np.int64)
    stretches = [slice(a, b) for a, b in zip(starts, [*starts[1:], len(values)], strict=True)]
    ends = [a.start + find(values[a]) for a in stretches for find in (np.argmin, np.argmax)]
    return np.unique(np.asarray(ends, np.int64))
