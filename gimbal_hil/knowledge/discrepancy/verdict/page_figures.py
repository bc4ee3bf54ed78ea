"""The figures of a discrepancy report: how large, where, over what, and over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from firmware_protocol.json_object import Json
from gimbal_hil.knowledge.discrepancy.hypotheses import torque_residual
from gimbal_hil.knowledge.discrepancy.judgement import Result
from gimbal_hil.knowledge.discrepancy.laws import DescribedLaw
from gimbal_hil.knowledge.discrepancy.twin import Floats
from gimbal_hil.knowledge.discrepancy.verdict.gaps import Gap
from gimbal_hil.knowledge.discrepancy.verdict.where import Regime, regimes
from gimbal_hil.pages.report import scaled_unit
from sim_backend.effects import Variable
from sim_backend.model import UNIT_OF, UNIT_OVER, ActsOn

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing

#: slices of an abscissa that means are drawn for, rows that a mean takes at least
_SLICES, _LEAST_ROWS = 240, 4
#: dots of a cloud: a browser takes a tenth of a millisecond for each, and the means say what the cloud does
_DOTS = 400
#: share of the axis from which on a bar is seen
_SEEN = 0.01
#: share of time or gap from which on the rest of a group gets a bar
_A_REST = 0.005


def gap_figure(verdict: Json) -> Drawing:
    """Rms left per channel, in noise floors; after only where something is told that would close it."""
    from gimbal_hil.pages.plots import MODEL, REFERENCE, SECOND, figure, in_floors

    labels = [f"{g['axis']}<br>{g['signal'].replace('_', ' ')}" for g in verdict["gaps"]]
    drawn = figure("Left over, in noise floors", "", "rms / noise floor", 360)
    drawn_shares: list[float] = []
    after = [("after", "after", MODEL)] if verdict["effects"] or verdict["laws"] else []
    for name, key, colour in (
        ("before" if after else "left", "before", REFERENCE),
        *after,
        ("processing floor", "processing_floor", SECOND),
    ):
        shares = [gap[key] / gap["noise_floor"] for gap in verdict["gaps"]]
        # a bar that nobody sees needs no word in the legend; that nothing is seen after says what the page is for
        if key == "processing_floor" and max(shares) <= _SEEN * max([1.0, *drawn_shares]):
            continue
        drawn.add_bar(name=name, x=labels, y=shares, marker=dict(color=colour))
        drawn_shares += shares
    # room for the words of the line beside the last bars
    drawn.update_xaxes(range=[-0.5, len(labels) - 0.1], tickangle=0)
    in_floors(drawn, drawn_shares)
    return drawn


def _column_of(result: Result, gap: Gap) -> int:
    """The channel of a gap."""
    channels = result.inquiry.twin.channels
    return next(j for j, c in enumerate(channels) if (c.axis, c.signal) == (gap.axis, gap.signal))


def where_figure(result: Result, gap: Gap) -> Drawing:
    """Shares of the squared gap: for every way to cut the data one group of bars that adds up to 1."""
    from gimbal_hil.pages.plots import ALERT, MEASURED, figure

    j = _column_of(result, gap)
    channel = result.inquiry.twin.channels[j]
    found = with_the_rest(regimes(result.inquiry.twin, result.null.fitted, channel, j))
    title = f"Where the gap of {channel.axis} {channel.signal.replace('_', ' ')} sits"
    drawn = figure(title, "share of squared gap", "", 120 + 26 * len(found))
    # two columns of labels: the group once, and what each bar is
    labels = [[r.group.value for r in found], [r.regime for r in found]]
    drawn.add_bar(
        y=labels,
        x=[r.share_of_gap for r in found],
        orientation="h",
        name="share of gap",
        marker=dict(color=MEASURED),
        error_x=dict(
            type="data",
            symmetric=False,
            array=[max(0.0, r.high - r.share_of_gap) for r in found],
            arrayminus=[max(0.0, r.share_of_gap - r.low) for r in found],
        ),
    )
    drawn.add_scatter(
        y=labels,
        x=[r.share_of_time for r in found],
        mode="markers",
        name="share of time",
        marker=dict(symbol="line-ns-open", size=14, color=ALERT),
    )
    drawn.update_xaxes(range=[0.0, 1.02])
    drawn.update_yaxes(autorange="reversed", dividercolor="#c8d0d8")
    return drawn


def with_the_rest(found: Sequence[Regime]) -> list[Regime]:
    """Regimes group by group, each group with what lies in none of its regimes, so that its shares add up to 1."""
    whole: list[Regime] = []
    for group in dict.fromkeys(r.group for r in found):
        own = [r for r in found if r.group == group]
        gap, time = 1.0 - sum(r.share_of_gap for r in own), 1.0 - sum(r.share_of_time for r in own)
        whole += own
        if gap > _A_REST or time > _A_REST:
            gap = max(0.0, gap)
            # of a group of one, the rest is known as well as that one
            low, high = (1.0 - own[0].high, 1.0 - own[0].low) if len(own) == 1 else (gap, gap)
            whole.append(Regime(own[0].axis, own[0].signal, "the rest", group, gap, low, high, max(0.0, time)))
    return whole


def over_figure(result: Result, gap: Gap) -> Drawing:
    """What is left of the channel that the text speaks of, over position, speed and temperature of its axis."""
    from gimbal_hil.pages.plots import MODEL, REFERENCE, figure_of_panels, thinned

    inquiry = result.inquiry
    j = _column_of(result, gap)
    floor = float(inquiry.floor[j])
    before, after = (
        floor * torque_residual(under.holdout, state.hypothesis, inquiry.floor)[:, j]
        for state, under in ((result.stated, inquiry), (result.best, result.under))
    )
    over = _abscissas(result, gap.axis)
    factor, unit = scaled_unit(float(np.max(np.abs(before), initial=0.0)), gap.unit)
    before, after = factor * before, factor * after
    word = gap.signal.replace("_", " ")
    both = ", before and after" if explained(result) else ""
    title = f"{gap.axis} {word} left over{both}"
    drawn = figure_of_panels([name for name, _ in over], f"{word} left [{unit}]", 250, title)
    few = thinned(len(before), _DOTS)
    lines = [("before", before, REFERENCE)] + ([("after", after, MODEL)] if explained(result) else [])
    for row, (_, x) in enumerate(over, start=1):
        for name, left, colour in lines:
            dots = dict(mode="markers", marker=dict(size=4, color=colour, opacity=0.6))
            drawn.add_scatter(
                x=x[few], y=left[few], name=f"rows{f', {name}' if both else ''}", showlegend=row == 1, row=row, **dots
            )
            place, mean = sliced_mean(x, left)
            line = dict(color="#1c2530" if name == "before" else colour, width=1.5)
            drawn.add_scatter(
                x=place,
                y=mean,
                name=f"mean{f', {name}' if both else ''}",
                line=line,
                showlegend=row == 1,
                row=row,
                mode="lines",
            )
    return drawn


def explained(result: Result) -> bool:
    """Whether there is something after to be drawn."""
    return bool(result.told) or result.described is not None


def law_figure(result: Result, law: DescribedLaw) -> Drawing:
    """A law over its first variable, with its band, and what rows that had no part in it say."""
    from gimbal_hil.pages.plots import ALERT, MEASURED, MODEL, SECOND, figure, thinned

    shape, linear = law.curve.shape, result.model.is_linear
    over = shape.over[0]
    factor, unit = scaled_unit(float(np.max(np.abs(law.curve.values))), UNIT_OF[shape.acts_on][linear])
    drawn = figure(
        f"What is missing looks like {shape.text}",
        f"{over.value.replace('_', ' ')} [{UNIT_OVER[over][linear]}]",
        f"{shape.acts_on.value} [{unit}]",
        380,
    )
    few = thinned(len(law.at), _DOTS)
    if shape.acts_on is not ActsOn.FRICTION:
        dot = dict(size=3, color=MEASURED, opacity=0.35)
        drawn.add_scatter(
            x=law.at[few], y=factor * law.points[few], name="rows of the hold-out", mode="markers", marker=dot
        )
    for line, colour in zip(law.curve.lines(), (MODEL, SECOND, *[MODEL] * 8), strict=False):
        for end in (line.low, line.high):
            thin = dict(color=colour, width=0.6)
            drawn.add_scatter(x=line.x, y=factor * end, line=thin, showlegend=False, mode="lines")
        drawn.add_scatter(x=line.x, y=factor * line.y, line=dict(color=colour, width=2), name=line.name, mode="lines")
    if law.formula is not None and len(shape.over) == 1:
        x, dashed = law.curve.lines()[0].x, dict(color=ALERT, width=1.5, dash="dash")
        for k, y in enumerate(law.formula.at(x)):
            drawn.add_scatter(x=x, y=factor * y, line=dashed, name="the formula", showlegend=k == 0, mode="lines")
    return drawn


def sliced_mean(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Means of `x` and of `y`, both (n,), over slices of the range of `x`, in its order: equal slices, joined with the
    next where fewer than four rows lie in one.
    """
    low, high = float(np.min(x)), float(np.max(x))
    which = np.clip(((x - low) * (_SLICES / max(high - low, 1e-300))).astype(int), 0, _SLICES - 1)
    rows = np.bincount(which, minlength=_SLICES)
    joined, full, held = np.empty(_SLICES, int), 0, 0
    for k in range(_SLICES):
        joined[k] = full
        held += int(rows[k])
        if held >= _LEAST_ROWS:
            full, held = full + 1, 0
    # what is left over at the end belongs to the last full one
    slices = np.minimum(joined, max(0, full - 1))[which]
    count = np.maximum(np.bincount(slices), 1)
    return np.asarray(np.bincount(slices, x) / count), np.asarray(np.bincount(slices, y) / count)


def _abscissas(result: Result, axis: str) -> list[tuple[str, Floats]]:
    """(title with unit, values at the scored rows of the hold-out) of what a gap can depend on; time where it alone
    foretells it.
    """
    twin = result.inquiry.holdout
    i = twin.model.axes.index(axis)
    unit = "m" if twin.model.is_linear else "rad"

    def column(values: list[Floats]) -> Floats:
        return np.concatenate([r.at_scored(v) for r, v in zip(twin.records, values, strict=True)])

    found = [
        (f"position [{unit}]", column([r.motion[:, i] for r in twin.records])),
        (f"rate [{unit}/s]", column([r.motion[:, 2 + i] for r in twin.records])),
    ]
    if any(r.has_temperature for r in twin.records):
        found.append(("temperature [degC]", column([r.heat[:, i] for r in twin.records])))
    over = result.decision.depends_on
    if over is not None and over[0] is Variable.TIME:
        found.insert(0, ("time [s]", np.concatenate([r.time_s[r.keep] for r in twin.records])))
    return found


def time_figure(result: Result) -> Drawing:
    """What is left of the first hold-out log over time, every channel, in floors."""
    from gimbal_hil.pages.plots import ALERT, MODEL, REFERENCE, stacked, thinned

    search = result.inquiry
    before = torque_residual(search.holdout, result.null.hypothesis, search.floor)
    after = torque_residual(result.under.holdout, result.best.hypothesis, search.floor)
    first = int(search.holdout.records[0].keep.sum())
    time = search.holdout.records[0].time_s[search.holdout.records[0].keep]
    part = thinned(first, 2000)
    channels = search.twin.channels
    drawn = stacked(
        [f"{c.axis} {c.signal.replace('_', ' ')}" for c in channels], "time [s]", ["noise floors"] * len(channels)
    )
    for j in range(len(channels)):
        row = j + 1
        for name, rows, colour in (("before", before, REFERENCE), ("after", after, MODEL)):
            if name == "before" or explained(result):
                line = dict(color=colour, width=1)
                drawn.add_scatter(row, x=time[part], y=rows[:first, j][part], name=name, line=line, showlegend=row == 1)
        for level in (-1.0, 1.0):
            drawn.add_hline(y=level, row=row, color=ALERT, width=0.7)
    return drawn
