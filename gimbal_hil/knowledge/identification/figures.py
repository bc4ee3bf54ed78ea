"""Pictures of an identification, as figures that a page can hold."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gimbal_hil.knowledge.identification.correlations import Correlations
from gimbal_hil.knowledge.identification.estimate import Determination, Estimate, said
from gimbal_hil.knowledge.identification.output_error import OutputErrorFit, displacements
from gimbal_hil.knowledge.identification.presliding import PreslidingFit
from gimbal_hil.knowledge.identification.sliding import StaticFit
from gimbal_hil.knowledge.identification.stribeck import LugreFriction, StaticFriction
from gimbal_hil.knowledge.identification.units import ROTARY, Units
from gimbal_hil.knowledge.identification.velocity_map import VelocityMap
from gimbal_hil.pages.plots import ALERT, MEASURED, MODEL, REFERENCE, SECOND, figure, logarithm, stacked, thinned

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing


#: times the model's value at which an interval ends in a picture
_WIDEST = 5.0
#: a correlation of zero
_NOTHING = "#e8e8e8"
_COLOURS = {
    Determination.IDENTIFIED: MEASURED,
    Determination.WEAKLY_IDENTIFIED: SECOND,
    Determination.NOT_IDENTIFIED: REFERENCE,
}


def velocity_map_figure(
    velocity_map: VelocityMap, fits: tuple[StaticFit, ...], prior: StaticFriction, units: Units = ROTARY
) -> Drawing:
    """Friction torque over joint rate: measured points with 95 % bars, fitted curves, and the curve of the model one
    came with.

    The rate axis is logarithmic; both directions are shown at positive rate and torque.
    """
    drawn = figure(
        "Friction over speed", f"joint rate, size [{units.rate}]", f"friction {units.word}, size [{units.torque}]", 460
    )
    drawn.update_xaxes(**logarithm(abs(point.rate) for point in velocity_map.points))
    # six entries do not fit beside the title
    drawn.update_layout(legend={"y": -0.2, "yanchor": "top", "x": 0.0, "xanchor": "left"}, margin={"b": 90})
    for side, name, symbol in ((1.0, "measured, positive", "circle"), (-1.0, "measured, negative", "diamond-open")):
        points = [p for p in velocity_map.points if p.rate * side > 0.0]
        drawn.add_scatter(
            x=[abs(p.rate) for p in points], y=[p.torque * side for p in points], mode="markers", name=name,
            marker={"color": MEASURED if side > 0.0 else SECOND, "symbol": symbol, "size": 7},
            error_y={"type": "data", "array": [1.96 * p.standard_error for p in points], "thickness": 1},
            text=[", ".join(p.labels[:3]) for p in points],
        )  # fmt: skip
    speeds = np.array([abs(p.rate) for p in velocity_map.points])
    grid = np.geomspace(0.5 * speeds.min(), 1.2 * speeds.max(), 300)
    for fit, dash in zip(fits, ("solid", "dash", "dot"), strict=False):
        drawn.add_scatter(
            x=grid,
            y=fit.friction.torque(grid),
            mode="lines",
            name=f"fitted, {fit.direction.value}",
            line={"color": MODEL, "dash": dash},
        )
    drawn.add_scatter(
        x=grid, y=prior.torque(grid), mode="lines", name="model given", line={"color": REFERENCE, "width": 1.5}
    )
    return drawn


def residual_figure(fit: StaticFit, units: Units = ROTARY) -> Drawing:
    """Measured minus fitted size of the torque of every point over speed, with 95 % bars of the points' own errors."""
    drawn = figure(
        "Residuals of the velocity map", f"joint rate, size [{units.rate}]", f"measured - fitted [{units.torque}]", 320
    )
    for side, name, symbol in ((1.0, "positive", "circle"), (-1.0, "negative", "diamond-open")):
        places = [number for number, point in enumerate(fit.points) if point.rate * side > 0.0]
        drawn.add_scatter(
            x=[abs(fit.points[n].rate) for n in places], y=[side * fit.residuals[n] for n in places], mode="markers",
            name=name,
            marker={"color": MEASURED if side > 0.0 else SECOND, "symbol": symbol, "size": 7},
            error_y={"type": "data", "array": [1.96 * fit.points[n].standard_error for n in places], "thickness": 1},
        )  # fmt: skip
    drawn.update_xaxes(**logarithm(abs(point.rate) for point in fit.points))
    return drawn


def hysteresis_figure(fit: PreslidingFit, units: Units = ROTARY) -> Drawing:
    """Presliding loops: friction torque over displacement, measured and as the exact LuGre curve predicts it."""
    drawn = figure("Presliding", f"displacement [µ{units.angle}]", f"friction {units.word} [{units.torque}]", 460)
    for number, (run, predicted) in enumerate(zip(fit.runs, fit.predicted, strict=True)):
        rows = thinned(len(run.position), 1500)
        zero = run.position[0]
        first = number == 0
        drawn.add_scatter(
            x=1e6 * (run.position[rows] - zero), y=run.friction[rows], mode="lines", name="measured",
            legendgroup="measured",
            showlegend=first, line={"color": MEASURED, "width": 1},
        )  # fmt: skip
        drawn.add_scatter(
            x=1e6 * (predicted[rows] - zero), y=run.friction[rows], mode="lines", name="LuGre", legendgroup="model",
            showlegend=first,
            line={"color": MODEL, "width": 1.5, "dash": "dash"},
        )  # fmt: skip
    drawn.update_layout(hovermode="closest")
    return drawn


def output_error_figure(fit: OutputErrorFit, number: int = 0, units: Units = ROTARY) -> Drawing:
    """One record of the output-error fit: torque, joint rate measured and simulated, and their difference."""
    record, simulated = fit.records[number], fit.simulated[number]
    time = np.arange(len(record.position)) * record.step_s
    compare = max(record.step_s, 0.01)
    stride = max(1, int(round(compare / record.step_s)))
    measured = displacements(record.position, record.step_s, compare) / (stride * record.step_s)
    modelled = displacements(simulated, record.step_s, compare) / (stride * record.step_s)
    titles = (f"{units.word} that drives inertia and friction", "joint rate", "difference")
    drawn = stacked(titles, "time [s]", (f"[{units.torque}]", f"[{units.rate}]", f"[{units.rate}]"))
    rows, coarse = thinned(len(time)), thinned(len(measured))
    drawn.add_scatter(
        x=time[rows], y=record.torque[rows], line={"color": REFERENCE, "width": 1}, name=units.word, row=1
    )
    moments = time[::stride][: len(measured)]
    drawn.add_scatter(
        x=moments[coarse], y=measured[coarse], line={"color": MEASURED, "width": 1}, name="measured", row=2
    )
    drawn.add_scatter(
        x=moments[coarse],
        y=modelled[coarse],
        line={"color": MODEL, "width": 1, "dash": "dash"},
        name="simulated",
        row=2,
    )
    drawn.add_scatter(
        x=moments[coarse],
        y=(measured - modelled)[coarse],
        line={"color": ALERT, "width": 1},
        name="difference",
        row=3,
    )
    return drawn


def correlation_figure(correlations: Correlations) -> Drawing:
    """Correlations of the errors of identified numbers: a square a pair, coloured and numbered."""
    # numbered, so that words stand at one side only
    names = [f"{said(name)} {place}" for place, name in enumerate(correlations.names, start=1)]
    drawn = figure("Correlations of the errors", "", "", 130 + 52 * len(names))
    pairs = [(i, j) for i in range(len(names)) for j in range(i + 1)]
    values = [float(correlations.matrix[pair]) for pair in pairs]
    drawn.add_scatter(
        x=[str(1 + j) for _, j in pairs], y=[names[i] for i, _ in pairs], mode="markers+text", showlegend=False,
        text=[f"{value:.2f}" for value in values], textfont={"color": [_on(value) for value in values]},
        marker={
            "symbol": "square", "size": 46, "color": values, "cmin": -1.0, "cmax": 1.0,
            "colorscale": [[0.0, SECOND], [0.5, _NOTHING], [1.0, MEASURED]],
        },
        customdata=[names[j] for _, j in pairs],
        hovertemplate="%{y}, %{customdata}: %{text}<extra></extra>",
    )  # fmt: skip
    drawn.update_xaxes(showgrid=False, zeroline=False, range=[-0.6, len(names) - 0.4])
    drawn.update_yaxes(showgrid=False, zeroline=False, range=[len(names) - 0.4, -0.6])
    drawn.update_layout(hovermode="closest")
    return drawn


def _on(value: float) -> str:
    """Colour of a number that is read on the square of a correlation."""
    return "#ffffff" if abs(value) > 0.6 else "#222222"


def interval_figure(estimates: tuple[Estimate, ...], reference: LugreFriction, names: tuple[str, ...]) -> Drawing:
    """By how much every parameter that the data determine differs from the model given, in percent of it: value and
    95 % interval, coloured by verdict. Those that kept the model's value have no place here: their bars would
    hide the rest.
    """
    known = dict(zip(names, reference.values().tolist(), strict=True))
    shown = [
        one for one in estimates if known.get(one.name, 0.0) > 0.0 and one.verdict is not Determination.NOT_IDENTIFIED
    ]
    drawn = figure("Change against the model given", "difference [% of the model's value]", "", 130 + 34 * len(shown))
    ends = [0.0]
    for estimate in shown:
        colour, name = _COLOURS[estimate.verdict], said(estimate.name)
        symbol = "circle" if estimate.verdict is Determination.IDENTIFIED else "circle-open"
        value, low, high = (
            100.0 * (float(np.clip(end / known[estimate.name], 0.0, _WIDEST)) - 1.0)
            for end in (estimate.value, estimate.interval.low, estimate.interval.high)
        )
        drawn.add_scatter(
            x=[low, high], y=[name] * 2, mode="lines", line={"color": colour, "width": 5}, showlegend=False
        )
        marker = {"color": colour, "size": 8, "symbol": symbol}
        drawn.add_scatter(x=[value], y=[name], mode="markers", marker=marker, showlegend=False)
        ends += [low, high]
    # a line that ends at the edge would look cut
    beyond = 0.06 * (max(ends) - min(ends)) or 1.0
    drawn.update_xaxes(range=[min(ends) - beyond, max(ends) + beyond])
    drawn.update_yaxes(autorange="reversed")
    drawn.add_vline(x=0.0, color=REFERENCE, width=1)
    drawn.update_layout(hovermode="closest")
    return drawn
