"""The page of a direction that was held: figures, error over time, where the joints went, when it was muted."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gimbal_hil.data.runs import AXES
from gimbal_hil.pages.report import Block, Callout, Heading, Page, Plot, Table, Text, Tiles, counted, quantity
from gimbal_hil.pointing.following.judging import HeldTrace, MuteChange, PointingFigures

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing

#: points of a line: the largest error of each interval, or one joint position in so many
_POINTS = 1200
_MOST_LISTED = 60
#: how sizes of an angle are written on an axis, by µrad
_DECADES = {
    1.0: "1 µrad",
    10.0: "10 µrad",
    1e2: "100 µrad",
    1e3: "1 mrad",
    1e4: "10 mrad",
    1e5: "100 mrad",
    1e6: "1 rad",
}
_UNITS = {"_urad": "µrad", "_s": "s"}
#: what each of the figures is
_WORDS = {
    "duration_s": "duration",
    "acquired_after_s": "until acquired",
    "settled_true_rms_urad": "error by the base's true motion, settled: rms",
    "settled_true_peak_urad": "error by the base's true motion, settled: largest",
    "settled_rms_urad": "error as host and encoders see it, settled: rms",
    "settled_peak_urad": "error as host and encoders see it, settled: largest",
    "true_rms_urad": "error by the base's true motion, from the acquisition on: rms",
    "true_peak_urad": "error by the base's true motion, from the acquisition on: largest",
    "rms_urad": "error as host and encoders see it, from the acquisition on: rms",
    "peak_urad": "error as host and encoders see it, from the acquisition on: largest",
    "muted_s": "muted",
    "muted_after_acquisition_s": "muted after the acquisition",
    "mutes_after_acquisition": "times muted after the acquisition",
    "beyond_without_mute_s": "beyond the limit and not muted",
    "longest_beyond_without_mute_s": "longest time beyond the limit and not muted",
    "coasting_s": "without a new attitude, carried on by rates",
    "reference_off_urad": "what was followed was off the target by, in 95 % of the ticks",
    "ticks": "ticks",
    "ticks_without_sample": "ticks without a sample",
    "ticks_skipped": "ticks skipped",
}


@dataclass(frozen=True)
class HeldTarget:
    """What was pointed at, on which antenna, what there is to say about it, and the antenna's axes."""

    name: str
    where: str
    about: str
    axes: Sequence[str] = AXES


def write_page(
    path: Path,
    held: HeldTarget,
    trace: HeldTrace,
    figures: PointingFigures,
    changes: Sequence[MuteChange],
    beyond_rad: float,
) -> Path:
    """The page of one target; answers its path."""
    known = not math.isnan(figures.true_rms_urad)
    acquired = not math.isinf(figures.acquired_after_s)
    seen = "as host and encoders see it"
    judged = _judged(figures)
    errors = [(judged.rms, f"rms {judged.word}, {seen}"), (judged.peak, f"peak {judged.word}, {seen}")]
    if known:
        truly = "by the base's true motion"
        errors.insert(0, (judged.true_rms, f"rms {judged.word}, {truly}"))
        errors[-1] = (judged.true_peak, f"peak {judged.word}, {truly}")
    tiles = [
        *((quantity(1e-6 * value, "rad") if acquired else "none", words) for value, words in errors),
        (f"{figures.muted_after_acquisition_s:.2f} s" if acquired else "none", "muted after the acquisition"),
        (f"{figures.acquired_after_s:.2f} s" if acquired else "never", "until acquired"),
    ]
    said = summary(held.name, figures)
    values = figures.as_dict()
    blocks: list[Block] = [
        Callout(said, _colour(figures)),
        Tiles(tiles),
        Text(held.about),
        Heading("Pointing error"),
        Plot(
            _error_figure(trace, beyond_rad, known),
            "Largest error in each interval drawn; dashed: beyond it the transmitter is muted. On a base at rest both "
            "errors are the same.",
        ),
        Heading("Joints"),
        Plot(_joints_figure(trace, held.axes), "Where the joints were: the base's motion and the target's together."),
        Heading("In figures"),
        Table(
            ("Figure", "Value", "Unit"),
            [(words, _cell(values[key]), _unit(key)) for key, words in _WORDS.items()],
            "Errors while not muted; settled is from 5 s after the acquisition on.",
        ),
        Heading("Mute signal"),
        Table(
            ("Time [s]", "State", "Muted", "Error [deg]"),
            [
                (
                    f"{_time(trace, change.tick):.3f}",
                    change.state,
                    "yes" if change.muted else "no",
                    f"{math.degrees(change.error_rad):.3f}",
                )
                for change in changes[:_MOST_LISTED]
            ],
            "Every change; the time is that of the plots.",
        ),
    ]
    return Page(f"Pointing at {held.name}", held.where, blocks).write(path)


def _colour(figures: PointingFigures) -> str:
    if math.isinf(figures.acquired_after_s) or not figures.followed_the_target:
        return "bad"
    return "good" if figures.mutes_after_acquisition == 0 else "warning"


def summary(name: str, figures: PointingFigures) -> str:
    """What counts, in one sentence."""
    if math.isinf(figures.acquired_after_s):
        return f"{name}: not acquired in {figures.duration_s:.1f} s."
    if not figures.followed_the_target:
        return (
            f"{name}: what was followed is not the target, {figures.reference_off_urad * 1e-6 * 180.0 / math.pi:.2f} "
            "degrees off; errors against that reference say nothing."
        )
    times, seconds = figures.mutes_after_acquisition, figures.muted_after_acquisition_s
    muted = f"muted {counted(times, 'time')}, {seconds:.2f} s in all" if times else "never muted"
    return f"{name}: acquired after {figures.acquired_after_s:.2f} s, then within {_error(figures)} and {muted}."


def _error(figures: PointingFigures) -> str:
    """The true error where it is known, that which host and encoders see behind it."""
    judged = _judged(figures)
    seen = f"{judged.rms:.1f} µrad rms, {judged.peak:.0f} at most"
    since = "" if judged.settled else " from then on (it ended before the axes had settled)"
    if math.isnan(figures.true_rms_urad):
        return f"{seen} as host and encoders see it{since} (the base's true motion is not known),"
    rms, peak = (math.degrees(1e-6 * one) for one in (judged.true_rms, judged.true_peak))
    true = f"{judged.true_rms:.1f} µrad ({rms:.2g}°) rms and {judged.true_peak:.0f} µrad ({peak:.2g}°) at most"
    return f"{true} of true error (as host and encoders measure it: {seen}){since},"


@dataclass(frozen=True)
class _Judged:
    """The errors that answer, in µrad: the settled ones, or those since the acquisition if it ended before."""

    settled: bool
    rms: float
    peak: float
    true_rms: float
    true_peak: float

    @property
    def word(self) -> str:
        return "settled" if self.settled else "since acquired"


def _judged(figures: PointingFigures) -> _Judged:
    if not math.isnan(figures.settled_rms_urad):
        return _Judged(
            True,
            figures.settled_rms_urad,
            figures.settled_peak_urad,
            figures.settled_true_rms_urad,
            figures.settled_true_peak_urad,
        )
    return _Judged(False, figures.rms_urad, figures.peak_urad, figures.true_rms_urad, figures.true_peak_urad)


def _unit(key: str) -> str:
    return next((unit for ending, unit in _UNITS.items() if key.endswith(ending)), "")


def _cell(value: float | int | None) -> str:
    return "-" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)


def _time(trace: HeldTrace, tick: int) -> float:
    step = float(np.median(np.diff(trace.time_s))) if len(trace.tick) > 1 else 0.0
    return float(trace.time_s[0]) + (tick - int(trace.tick[0])) * step


def _error_figure(trace: HeldTrace, beyond_rad: float, known: bool) -> Drawing:
    from gimbal_hil.pages.plots import ALERT, MEASURED, SECOND, figure

    drawn = figure("", "time [s]", "pointing error")
    every = max(1, len(trace.tick) // _POINTS)
    size = len(trace.tick) // every * every
    time_s = trace.time_s[:size:every]
    lines = [(trace.error, "as host and encoders see it", MEASURED)]
    lines += [(trace.true_error, "by the base's true motion", SECOND)] if known else []
    for error, label, colour in lines:
        most = np.nan_to_num(error[:size], nan=0.0).reshape(-1, every).max(axis=1)
        drawn.add_scatter(x=time_s, y=1e6 * most, name=label, line=dict(color=colour))
    drawn.add_scatter(
        x=[float(trace.time_s[0]), float(trace.time_s[-1])],
        y=[1e6 * beyond_rad] * 2,
        name="mute",
        mode="lines",
        line=dict(color=ALERT, dash="dash"),
    )
    drawn.update_yaxes(type="log", tickvals=list(_DECADES), ticktext=list(_DECADES.values()))
    return drawn


def _joints_figure(trace: HeldTrace, axes: Sequence[str]) -> Drawing:
    from gimbal_hil.pages.plots import AXIS_COLOURS, stacked

    drawn = stacked(("", ""), "time [s]", tuple(f"{axis} [deg]" for axis in axes), 200)
    few = slice(None, None, max(1, len(trace.tick) // _POINTS))
    for place, colour in enumerate(AXIS_COLOURS):
        drawn.add_scatter(
            x=trace.time_s[few],
            y=np.degrees(trace.joints[few, place]),
            line=dict(color=colour),
            showlegend=False,
            row=place + 1,
        )
    return drawn
