"""A figure as a file for papers and slides: SVG, PDF or PNG, drawn by Matplotlib from the same traces and layout.

The pages draw with plotly.js in a browser, which a script or a CI has not got. Colours, axes, units and names are those
of the page; what only a browser can do (zooming, buttons, words under the pointer) has no place here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.pages.plots.drawing import Drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Json = Mapping[str, Any]
#: endings that can be written
PICTURE_ENDINGS = (".svg", ".pdf", ".png")
#: a page's pixels a Matplotlib inch, and dots a inch of a PNG
_PX_PER_INCH, _DOTS = 110.0, 160
_WIDTH_PX = 900.0
_DASHES = {"dash": "--", "dot": ":", "dashdot": "-."}
_SYMBOLS = {"circle": "o", "square": "s", "diamond": "D", "triangle-up": "^", "triangle-down": "v", "line-ns": "|"}


def write_picture(drawing: Drawing, path: Path, title: str = "") -> Path:
    """Write it and answer the path. BadInputError for another ending, or where Matplotlib is not installed."""
    if path.suffix not in PICTURE_ENDINGS:
        raise BadInputError(str(path), f"has the ending {path.suffix or 'none'}", ", ".join(PICTURE_ENDINGS))
    try:
        from matplotlib.figure import Figure
    except ImportError:
        problem = f"a picture as {path.suffix[1:]} needs the package matplotlib, which is not installed"
        raise BadInputError(str(path), problem, "pip install 'gimbal-hil[pictures]', or an .html page") from None
    layout = drawing.layout
    height = float(layout.get("height", 400))
    figure = Figure(figsize=(_WIDTH_PX / _PX_PER_INCH, height / _PX_PER_INCH), layout="constrained")
    panels = np.atleast_1d(figure.subplots(drawing.panels, 1))
    for number, axes in enumerate(panels):
        place = "" if number == 0 else str(number + 1)
        traces = [trace for trace in drawing.data if trace["yaxis"] == f"y{place}"]
        _draw_panel(axes, drawing, traces, place)
    heading = str(layout["title"].get("text", "")) or title
    if heading:
        figure.suptitle(heading, x=0.01, ha="left", fontsize=11)
    figure.savefig(path, dpi=_DOTS)
    return path


def _draw_panel(axes: Axes, drawing: Drawing, traces: Sequence[Json], place: str) -> None:
    layout = drawing.layout
    colours = list(layout.get("colorway", ["#1f6f8b"]))
    x_axis, y_axis = layout[f"xaxis{place}"], layout[f"yaxis{place}"]
    bars = [trace for trace in traces if trace["type"] == "bar"]
    for number, trace in enumerate(traces):
        colour = colours[number % len(colours)]
        label = str(trace.get("name", "")) if trace.get("showlegend", True) else ""
        if trace["type"] == "bar":
            _draw_bars(axes, trace, bars.index(trace), len(bars), colour, label)
        else:
            _draw_points(axes, trace, colour, label)
    for shape in layout["shapes"]:
        if shape["yref"].removesuffix(" domain") != f"y{place}":
            continue
        style = _style(shape["line"], "#8a94a0")
        if shape["y0"] == shape["y1"]:
            axes.axhline(shape["y0"], **style)
        else:
            axes.axvline(shape["x0"], **style)
    _scale(axes, x_axis, "x")
    _scale(axes, y_axis, "y")
    axes.set_xlabel(_words(x_axis)) if x_axis.get("showticklabels", True) else axes.tick_params(labelbottom=False)
    axes.set_ylabel(_words(y_axis))
    axes.grid(color="#e4e9ef", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=8)
    # a name alone is the title's
    if axes.get_legend_handles_labels()[1] and len({trace.get("name") for trace in drawing.data} - {None}) > 1:
        axes.legend(fontsize=8, frameon=False, loc="best")
    heads = [one["text"] for one in layout["annotations"] if one.get("yref") == f"y{place} domain"]
    if heads:
        axes.set_title(heads[0], loc="left", fontsize=9)


def _draw_points(axes: Axes, trace: Json, colour: str, label: str) -> None:
    x, y = _values(trace["x"]), _values(trace["y"])
    mode, line, marker = str(trace.get("mode", "lines")), trace.get("line", {}), trace.get("marker", {})
    own = line.get("color", marker.get("color", colour))
    if "lines" in mode:
        drawn = "steps-post" if line.get("shape") == "hv" else "default"
        axes.plot(x, y, label=label, drawstyle=drawn, **_style(line, own if isinstance(own, str) else colour))
        label = ""
    if "markers" in mode:
        _draw_markers(axes, trace, x, y, colour, label)
    for which in ("error_x", "error_y"):
        error = trace.get(which)
        if error:
            spread = {f"{which[-1]}err": _error(error)}
            axes.errorbar(x, y, fmt="none", ecolor=own if isinstance(own, str) else colour, elinewidth=0.9, **spread)
    if "text" in mode:
        shades = trace.get("textfont", {}).get("color", "#1c2530")
        shades = [shades] * len(x) if isinstance(shades, str) else shades
        for at, height, words, shade in zip(x, y, trace.get("text", ()), shades, strict=False):
            axes.annotate(str(words), (at, height), ha="center", va="center", fontsize=8, color=shade)


def _draw_markers(axes: Axes, trace: Json, x: Any, y: Any, colour: str, label: str) -> None:
    marker = trace.get("marker", {})
    shades = marker.get("color", trace.get("line", {}).get("color", colour))
    symbols = marker.get("symbol", "circle")
    one = symbols if isinstance(symbols, str) else symbols[0] if len(symbols) else "circle"
    shape = _SYMBOLS.get(one.removesuffix("-open"), "o")
    size = np.asarray(marker.get("size", 6), float) ** 2 * (72.0 / _PX_PER_INCH) ** 2
    coloured: dict[str, Any] = {"color": shades}
    if not isinstance(shades, str) and len(shades) and not isinstance(shades[0], str):
        from matplotlib.colors import LinearSegmentedColormap

        scale = marker.get("colorscale", [[0.0, "#ffffff"], [1.0, colour]])
        coloured = {
            "c": _values(shades),
            "cmap": LinearSegmentedColormap.from_list("page", [(float(at), shade) for at, shade in scale]),
            "vmin": marker.get("cmin"),
            "vmax": marker.get("cmax"),
        }
    if one.endswith("-open") and isinstance(shades, str) and shape != "|":
        coloured = {"facecolors": "none", "edgecolors": shades}
    axes.scatter(x, y, s=size, marker=shape, alpha=float(marker.get("opacity", 1.0)), label=label, **coloured)


def _draw_bars(axes: Axes, trace: Json, number: int, count: int, colour: str, label: str) -> None:
    lying = trace.get("orientation") == "h"
    names = _names(trace["y" if lying else "x"])
    lengths = _values(trace["x" if lying else "y"])
    thick = 0.8 / count
    places = np.arange(len(names)) + (number - 0.5 * (count - 1)) * thick
    shade = trace.get("marker", {}).get("color", colour)
    error = trace.get("error_x" if lying else "error_y")
    spread = {("xerr" if lying else "yerr"): _error(error), "ecolor": "#2a3f5f"} if error else {}
    draw = axes.barh if lying else axes.bar
    draw(places, lengths, thick, color=shade, label=label, **spread)
    set_ticks = axes.set_yticks if lying else axes.set_xticks
    set_ticks(np.arange(len(names)), names)


def _scale(axes: Axes, axis: Json, which: str) -> None:
    logarithmic = axis.get("type") == "log"
    if logarithmic:
        (axes.set_xscale if which == "x" else axes.set_yscale)("log")
    limits = axes.set_xlim if which == "x" else axes.set_ylim
    span = axis.get("range")
    if span is not None:
        limits(*(10.0 ** np.asarray(span, float) if logarithmic else span))
    if "tickvals" in axis:
        kept = limits()
        words = [str(word) for word in axis.get("ticktext", axis["tickvals"])]
        (axes.set_xticks if which == "x" else axes.set_yticks)(axis["tickvals"], words, minor=False)
        limits(*kept)
    if axis.get("autorange") == "reversed":
        limits(*reversed(limits()))


def _style(line: Json, colour: str) -> dict[str, Any]:
    return {
        "color": line.get("color", colour),
        "linewidth": 0.75 * float(line.get("width", 1.6)),
        "linestyle": _DASHES.get(str(line.get("dash", "")), "-"),
    }


def _error(error: Json) -> Any:
    size = np.asarray(error["array"], float)
    return size if error.get("symmetric", True) else np.vstack([np.asarray(error["arrayminus"], float), size])


def _values(values: Any) -> Any:
    """Numbers with NaN where there is none; names as they are."""
    found = list(values)
    if any(isinstance(value, str) for value in found):
        return [_lines(value) for value in found]
    return np.array([np.nan if value is None else float(value) for value in found])


def _names(labels: Any) -> list[str]:
    """Labels of bars; of two columns of labels both."""
    if len(labels) == 2 and not isinstance(labels[0], str):
        return [f"{group}: {one}" for group, one in zip(*labels, strict=True)]
    return [_lines(label) for label in labels]


def _lines(label: object) -> str:
    """A label of several lines, which a page parts by the element for it."""
    return str(label).replace("<br>", "\n")


def _words(axis: Json) -> str:
    return str(axis.get("title", {}).get("text", ""))
