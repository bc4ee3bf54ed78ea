"""Figures of the thesis report, after those of the thesis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gimbal_hil.pages.plots import ALERT, MEASURED, MODEL, REFERENCE, SECOND, figure, logarithm, thinned
from gimbal_hil.proof.thesis.controller_tables import Agreement, TableResult
from gimbal_hil.proof.thesis.friction_curves import FrictionCurves
from gimbal_hil.proof.thesis.printed import Loop
from gimbal_hil.proof.thesis.sliding import SlidingSweep
from gimbal_hil.proof.thesis.step_size import Convergence
from gimbal_hil.proof.thesis.unbalance import Unbalance, UnbalanceRun

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing

_COLOURS = ("#17324a", "#1f6f8b", "#4fa3a5", "#d1a23d", "#d1603d", "#b3261e", "#6a4c93")
_AGREEMENT_COLOURS = {
    Agreement.REPRODUCED: MEASURED,
    Agreement.CLOSE: "#d1a23d",
    Agreement.OVERSHOOT_ONLY: SECOND,
    Agreement.NOT_REPRODUCIBLE: ALERT,
}
#: more samples than a screen has pixels across
_SHOWN = 900


def overshoot_figure(tables: Sequence[TableResult]) -> Drawing:
    """Every printed overshoot against the one found here; on the diagonal they agree."""
    drawn = figure("Overshoot, thesis against here", "printed (%)", "here (%)")
    for agreement, colour in _AGREEMENT_COLOURS.items():
        alike = [result for result in tables if result.agreement is agreement]
        shown = [row for result in alike for row in result.rows if row.overshoot_percent < 100.0]
        drawn.add_scatter(
            x=[row.printed.overshoot_percent for row in shown],
            y=[row.overshoot_percent for row in shown],
            mode="markers",
            name=f"{agreement.value}: {', '.join(result.table.number for result in alike)}",
            marker={"color": colour, "size": 8},
        )
    drawn.add_scatter(x=[0, 40], y=[0, 40], mode="lines", name="equal", line={"color": REFERENCE, "width": 1})
    drawn.update_layout(
        hovermode="closest", legend={"orientation": "v", "x": 1.02, "xanchor": "left", "y": 1.0, "yanchor": "top"}
    )
    return drawn


def step_figure(result: TableResult) -> Drawing:
    """The step responses of a table, one line a row."""
    is_rate = result.table.loop is Loop.RATE
    drawn = figure(
        f"Table {result.table.number}: {result.table.loop.value} loop, {result.table.axis} axis",
        "time (s)",
        "inertial rate (rad/s)" if is_rate else "position (rad)",
    )
    index = 0 if result.table.axis == "outer" else 1
    for colour, row, response in zip(_COLOURS, result.rows, result.responses, strict=False):
        if row.overshoot_percent > 100.0:
            continue
        signal = (response.rate_rad_s if is_rate else response.position_rad)[:, index]
        keep = thinned(len(signal), _SHOWN)
        drawn.add_scatter(
            x=response.time_s[keep],
            y=signal[keep].astype("float32"),
            mode="lines",
            name=f"{result.table.swept} {row.printed.swept:g}",
            line={"color": colour},
        )
    return drawn


def unbalance_figure(runs: Sequence[UnbalanceRun], unbalance: Unbalance, axis: str, reference_rad_s: float) -> Drawing:
    """Rates of one axis over the cases of a table, as figures 3.3 to 3.13."""
    drawn = figure(
        f"{axis} axis, {unbalance.value} unbalance, reference {reference_rad_s:g} rad/s (table {unbalance.table})",
        "time (s)",
        "inertial rate (rad/s)",
    )
    index = 0 if axis == "outer" else 1
    for colour, run in zip(
        _COLOURS,
        (r for r in runs if (r.unbalance, r.axis, r.reference_rad_s) == (unbalance, axis, reference_rad_s)),
        strict=False,
    ):
        keep = thinned(len(run.response.time_s), _SHOWN)
        drawn.add_scatter(
            x=run.response.time_s[keep],
            y=run.response.rate_rad_s[keep, index].astype("float32"),
            mode="lines",
            name=f"case {run.case}",
            line={"color": colour},
        )
    return drawn


def friction_figure(curves: FrictionCurves, sweep: SlidingSweep) -> Drawing:
    """Friction over velocity as in figures 4.2 to 4.5: the steady curve, and what the sliding experiment finds on the
    antenna.
    """
    drawn = figure(f"{curves.axis} axis: friction over velocity", "joint rate (rad/s)", "friction (N m)")
    drawn.add_scatter(
        x=curves.rate_rad_s,
        y=curves.steady_nm,
        mode="lines",
        name="steady curve, eq. 4.3 corrected",
        line={"color": MODEL},
    )
    drawn.add_scatter(
        x=sweep.rate_rad_s,
        y=sweep.friction_nm,
        mode="markers",
        name="sliding experiment, windows of 0.5 s",
        marker={"color": MEASURED, "size": 6},
    )
    drawn.add_vline(x=curves.minimum_rad_s, color=REFERENCE, dash="dot")
    return drawn


def loop_figure(curves: FrictionCurves) -> Drawing:
    """The loop around zero speed of figures 4.6 and 4.7, for three periods of the sine."""
    drawn = figure(
        f"{curves.axis} axis: friction along one sine period of velocity", "joint rate (rad/s)", "friction (N m)"
    )
    for colour, loop in zip((ALERT, MODEL, MEASURED), curves.loops, strict=True):
        keep = thinned(len(loop.rate_rad_s), _SHOWN)
        drawn.add_scatter(
            x=loop.rate_rad_s[keep],
            y=loop.torque_nm[keep],
            mode="lines",
            name=f"period {loop.period_s:g} s",
            line={"color": colour},
        )
    drawn.update_layout(hovermode="closest")
    return drawn


def temperature_figure(sweeps: Sequence[SlidingSweep]) -> Drawing:
    """Sliding friction over speed at each temperature."""
    drawn = figure(f"{sweeps[0].axis} axis: sliding friction over temperature", "joint rate (rad/s)", "friction (N m)")
    for colour, sweep in zip(_COLOURS, sweeps, strict=False):
        drawn.add_scatter(
            x=sweep.rate_rad_s,
            y=sweep.friction_nm,
            mode="lines+markers",
            name=f"{sweep.temperature_degc:g} degC",
            line={"color": colour},
        )
    drawn.update_xaxes(**logarithm(rate for sweep in sweeps for rate in sweep.rate_rad_s))
    return drawn


def convergence_figure(found: Convergence) -> Drawing:
    """Error over step, and the slope of a second-order method."""
    drawn = figure("The plant's error over its step", "plant step (ms)", "position error after a second (µrad)")
    step_ms, error_urad = (
        [factor * value for value in of] for factor, of in ((1e3, found.step_s), (1e6, found.error_rad))
    )
    drawn.add_scatter(x=step_ms, y=error_urad, mode="lines+markers", name="whole antenna", line={"color": MEASURED})
    slope = [error_urad[-1] * (step / step_ms[-1]) ** 2 for step in step_ms]
    drawn.add_scatter(x=step_ms, y=slope, mode="lines", name="second order", line={"color": REFERENCE, "dash": "dot"})
    drawn.update_xaxes(**logarithm(step_ms))
    drawn.update_yaxes(**logarithm(error_urad))
    return drawn
