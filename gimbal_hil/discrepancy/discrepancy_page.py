"""The report: what was found in plain words, where the gap sits, the ranking, before and after, and what the model file
gained.
"""

from __future__ import annotations

import difflib
from typing import Any

from gimbal_hil.discrepancy.evidence import torque_residual
from gimbal_hil.discrepancy.inquiry import gain_on
from gimbal_hil.discrepancy.run import Result
from gimbal_hil.discrepancy.verdict import Verdict
from gimbal_hil.discrepancy.where import regimes
from gimbal_hil.report import Block, Callout, Details, Heading, Listing, Page, Plot, Table, Text, Tiles
from sim_backend.model import AntennaModel

_GAP_CAPTION = (
    "Rms left over per channel on hold-out rows that neither selected nor tuned, before and after, beside noise and"
    " processing."
)
_TONE = {"named": "good", "no_discrepancy": "good", "ambiguous": "warning", "unexplained": "warning"}


def discrepancy_page(result: Result, found: Verdict, corrected: AntennaModel | None, sources: list[str]) -> Page:
    """The page for one result."""
    verdict = found.document
    gap = verdict["gap"]
    blocks: list[Block] = [
        Callout(verdict["text"], _TONE[verdict["verdict"]]),
        *(Callout(f"{against['axis']}: {against['text']}.", "warning") for against in verdict["contradictions"]),
        Tiles(
            (
                (verdict["verdict"].replace("_", " "), "verdict"),
                (
                    f"{gap['before'] / gap['noise_floor']:.1f} → {gap['after'] / gap['noise_floor']:.1f}",
                    f"largest gap in floors, {gap['axis']} {gap['signal']}",
                ),
                (
                    "-" if gap["closed_fraction"] is None else f"{gap['closed_fraction']:.1%}",
                    "of the gap closed on untouched data",
                ),
                (f"{gap['noise_floor']:.2g} {gap['unit']}", "noise floor"),
            )
        ),
        Heading("How large the gap is"),
        Plot(_gap_figure(verdict), _GAP_CAPTION),
    ]
    if verdict["effects"]:
        blocks += [Heading("What was named"), _effects_table(verdict)]
    if verdict["alternatives"]:
        blocks += [Heading("What it could also be"), _alternatives(verdict)]
    if verdict["next_experiment"]:
        blocks.append(Callout(f"Run this next: {verdict['next_experiment']['plan']}", "neutral"))
    blocks += [
        Heading("Where it sits"),
        Plot(
            _where_figure(result, verdict),
            "Share of the squared gap by regime with 90 % block-bootstrap intervals; the mark is the share of time.",
        ),
    ]
    rivals = _rivals(result)
    blocks += [Heading("What was tried"), _ranking(result), *([rivals] if rivals else [])]
    blocks += [
        Heading("Before and after"),
        Plot(
            _time_figure(result),
            "Left over on the hold-out, before and, where something explains it, after; lines: the noise floor.",
        ),
    ]
    if corrected is not None:
        change = "\n".join(
            difflib.unified_diff(
                result.model.to_yaml().splitlines(),
                corrected.to_yaml().splitlines(),
                "model",
                "corrected",
                lineterm="",
                n=2,
            )
        )
        blocks += [
            Heading("What the model file gained"),
            Listing(change, "Difference between the input model and model.yaml."),
        ]
    if verdict["recalibrated"]:
        rows = [
            (r["axis"], r["path"], f"{r['nominal']:.4g}", f"{r['value']:.4g}", f"{r['value'] / r['nominal'] - 1:+.1%}")
            for r in verdict["recalibrated"]
        ]
        blocks.append(
            Details("Known numbers that had to float", [Table(("axis", "number", "model", "refitted", "change"), rows)])
        )
    if verdict["not_testable"]:
        unseen = [(n["name"], n["axis"], n["reason"]) for n in verdict["not_testable"]]
        blocks.append(Details("What this data cannot show", [Table(("effect", "axis", "reason"), unseen)]))
    notes = [note for record in (*result.inquiry.twin.records,) for note in ([record.source] if record.source else [])]
    blocks.append(Details("Data", [Text("; ".join(sources)), *([Text("; ".join(notes))] if notes else [])]))
    return Page(
        "What the model is missing",
        f"Model {result.model.name}; verdict: {verdict['verdict'].replace('_', ' ')}",
        blocks,
    )


def _gap_figure(verdict: dict[str, Any]) -> Any:
    import plotly.graph_objects as go

    from gimbal_hil.plots import ALERT, MODEL, REFERENCE, SECOND, figure

    labels = [f"{g['axis']} {g['signal'].replace('_', ' ')}" for g in verdict["gaps"]]
    drawn = figure("Left over, in noise floors", "", "rms / noise floor", 360)
    drawn.add_trace(
        go.Bar(
            name="before", x=labels, y=[g["before"] / g["noise_floor"] for g in verdict["gaps"]], marker_color=REFERENCE
        )
    )
    drawn.add_trace(
        go.Bar(name="after", x=labels, y=[g["after"] / g["noise_floor"] for g in verdict["gaps"]], marker_color=MODEL)
    )
    drawn.add_trace(
        go.Bar(
            name="processing floor",
            x=labels,
            y=[g["processing_floor"] / g["noise_floor"] for g in verdict["gaps"]],
            marker_color=SECOND,
        )
    )
    drawn.add_hline(y=1.0, line_color=ALERT)
    # on a logarithmic axis annotations stand at the logarithm
    drawn.add_annotation(
        x=1.0, xref="paper", xanchor="right", y=0.0, yanchor="bottom", text="noise floor", showarrow=False
    )
    # one, two and five of every decade that a bar can reach, written out
    ticks = [digit * 10.0**decade for decade in range(-3, 7) for digit in (1, 2, 5)]
    drawn.update_yaxes(type="log", tickvals=ticks, ticktext=[f"{tick:g}" for tick in ticks])
    return drawn


def _effects_table(verdict: dict[str, Any]) -> Table:
    rows = []
    for e in verdict["effects"]:
        for name, p in e["parameters"].items():
            nominal = "" if p["nominal"] is None else f"{p['nominal']:.4g}"
            value, interval = (
                f"{p['value']:.4g} {p['unit'] if p['unit'] != '1' else ''}".rstrip(),
                f"{p['low']:.4g} .. {p['high']:.4g}",
            )
            rows.append(
                (
                    f"{e['name']} ({e['axis']})",
                    e["status"],
                    name,
                    value,
                    interval,
                    nominal,
                    f"{e['held_out_gain']:.1%}",
                    f"{e['best_control_gain']:.1%}",
                    f"{e['confidence']:.2f}",
                )
            )
    header = ("effect", "status", "parameter", "value", "interval", "model had", "gain", "control", "confidence")
    return Table(
        header,
        rows,
        "Gain: share of the gap that the effect takes on the hold-out; control: what its negative control takes.",
    )


def _alternatives(verdict: dict[str, Any]) -> Table:
    return Table(
        ("could also be", "axis", "instead of", "why"),
        [(a["name"], a["axis"], a["instead_of"], a["reason"]) for a in verdict["alternatives"]],
    )


def _where_figure(result: Result, verdict: dict[str, Any]) -> Any:
    import plotly.graph_objects as go

    from gimbal_hil.plots import ALERT, MEASURED, figure

    residual = result.null.fitted
    # the channel that the text speaks of
    gap = verdict["gap"]
    j = next(
        j for j, c in enumerate(result.inquiry.twin.channels) if (c.axis, c.signal) == (gap["axis"], gap["signal"])
    )
    found = regimes(result.inquiry.twin, residual, result.inquiry.twin.channels[j], j)
    labels = [f"{r.group}: {r.regime}" for r in found]
    drawn = figure(
        f"Where the gap of {found[0].axis} {found[0].signal} sits" if found else "Where",
        "share of the squared gap",
        "",
        120 + 26 * len(found),
    )
    drawn.add_trace(
        go.Bar(
            y=labels,
            x=[r.share_of_gap for r in found],
            orientation="h",
            name="share of gap",
            marker_color=MEASURED,
            error_x=dict(
                type="data",
                symmetric=False,
                array=[r.high - r.share_of_gap for r in found],
                arrayminus=[r.share_of_gap - r.low for r in found],
            ),
        )
    )
    drawn.add_trace(
        go.Scatter(
            y=labels,
            x=[r.share_of_time for r in found],
            mode="markers",
            name="share of time",
            marker=dict(symbol="line-ns-open", size=14, color=ALERT),
        )
    )
    drawn.update_layout(margin=dict(l=260))
    drawn.update_yaxes(autorange="reversed")
    return drawn


def _ranking(result: Result) -> Table:
    rows = []
    for number, one in enumerate(result.path.rounds, start=1):
        for tried in one.tried[:6]:
            effect, axis = tried.hypothesis.labels[-1]
            fitted, held = (gain_on(result.inquiry, one.before, tried, part) for part in ("fitted", "selecting"))
            control = one.controls.get((effect, axis))
            rows.append(
                (
                    str(number),
                    effect,
                    axis,
                    f"{fitted.mean:.3g}",
                    f"{fitted.sure:.1f}",
                    f"{held.mean:.3g}",
                    f"{held.sure:.1f}",
                    "" if control is None else f"{control:.3g}",
                )
            )
    header = ("round", "candidate", "axis", "takes, fitted", "sure", "takes, hold-out", "sure", "its control takes")
    return Table(
        header,
        rows,
        "What a candidate takes, in mean squares of what was left before it, on the fitted logs and on the part of the "
        "hold-out that "
        "selects; sure: standard errors over blocks. A control is the candidate's own response, scrambled in time.",
    )


def _rivals(result: Result) -> Table | None:
    """What was put in the place of each cause; None where nothing was."""
    rows = []
    policy = result.inquiry.policy
    for one in result.told:
        name = f"{one.standing.label[0]} ({one.standing.label[1]})"
        for rival in one.standing.rivals[:4]:
            apart = "no" if rival.close(policy.same, policy.sure) else "yes"
            rows.append(
                (name, f"{rival.label[0]} ({rival.label[1]})", f"{rival.sure:.1f}", f"{rival.extra:+.1%}", apart)
            )
    caption = (
        "Every cause beside what could stand in its place, refitted there: by how many standard errors over blocks, and"
        " by which share of "
        f"what is left, it explains less. Under {policy.sure:g}, or by less than {policy.same:.1%}, they cannot be told"
        " apart."
    )
    return (
        Table(("cause", "in its place", "standard errors", "squares left", "told apart"), rows, caption)
        if rows
        else None
    )


def _time_figure(result: Result) -> Any:
    import plotly.graph_objects as go

    from gimbal_hil.plots import ALERT, MODEL, REFERENCE, stacked, thinned

    search = result.inquiry
    before = torque_residual(search.holdout, result.null.hypothesis, search.floor)
    after = torque_residual(search.holdout, result.best.hypothesis, search.floor)
    first = int(search.holdout.records[0].keep.sum())
    time = search.holdout.records[0].time_s[search.holdout.records[0].keep]
    part = thinned(first, 2500)
    channels = search.twin.channels
    drawn = stacked(
        [f"{c.axis} {c.signal.replace('_', ' ')}" for c in channels], "time [s]", ["floors"] * len(channels)
    )
    for j in range(len(channels)):
        row = j + 1
        drawn.add_trace(
            go.Scatter(
                x=time[part],
                y=before[:first, j][part],
                name="before",
                line=dict(color=REFERENCE, width=1),
                showlegend=row == 1,
            ),
            row=row,
            col=1,
        )
        if result.told:
            drawn.add_trace(
                go.Scatter(
                    x=time[part],
                    y=after[:first, j][part],
                    name="after",
                    line=dict(color=MODEL, width=1),
                    showlegend=row == 1,
                ),
                row=row,
                col=1,
            )
        for level in (-1.0, 1.0):
            drawn.add_hline(y=level, line_color=ALERT, line_width=0.7, row=row, col=1)
    return drawn
