"""How else the torque column of a log may have come about, where its numbers leave that open.

A torque that is the same for five rows was in force for them, is their mean, or was asked for only every fifth row; an
early one is early, or the position comes late through a low-pass. No number may depend on which: the regression is made
for each, and the intervals hold all that the log leaves possible. `torque_column` has what zeros, steps and extremes
leave open.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from gimbal_hil.knowledge.estimation import ShiftedFit, ShiftedProblem, Smoothing, fit_shifted
from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.axis_motion import AxisMotion
from gimbal_hil.knowledge.identification.estimate import DataWarning, Interval
from gimbal_hil.knowledge.identification.position_ripple import OverPosition
from gimbal_hil.knowledge.identification.smoothed_log import SmoothedColumn, SmoothedLog

#: rows of one torque that are a stair, and the longest; so many stairs, and this share of them of one length but a row
_LEAST_ROWS, _MOST_ROWS, _FEWEST, _ALMOST_ALL = 1.8, 50.0, 50, 0.9
#: a position behind a low-pass is possible where the squares that are left are at most so many times those of the plain
#: one
_POSSIBLE = 1.5
#: a mean that is held for the rows that it was taken over is a mean over twice as many squares of rows
_TWICE = 2.0**0.5
#: rounds in which the lag of a position settles
_ROUNDS = 3

Ripples = tuple[OverPosition, ...]
Problems = list[tuple[ShiftedProblem, Vector]]


def stair_of(torque: Vector) -> float:
    """Rows for which a torque (n,) that is refreshed every so many stays the same; 1 for any other."""
    changes = np.flatnonzero(np.diff(torque))
    rows = np.diff(changes)
    if len(rows) < _FEWEST:
        return 1.0
    usual = float(np.median(rows))
    alike = np.abs(rows - usual) <= 1.0
    mean = float(np.mean(rows[alike]))
    return mean if np.mean(alike) > _ALMOST_ALL and _LEAST_ROWS <= mean <= _MOST_ROWS else 1.0


def two_clocks(late: Sequence[Interval]) -> tuple[DataWarning, ...]:
    """What a reader must know of a log whose first and last thirds are `late` by different times, if they are."""
    if not late:
        return ()
    first, last = (f"{1e3 * one.low:.3g} to {1e3 * one.high:.3g} ms" for one in late)
    text = (
        f"the torque column is {first} late against the positions in the first third of this log, {last} in the last: "
        "they were stamped by two clocks, or rows of one are missing; the intervals hold the numbers of both"
    )
    return (DataWarning("two_clocks", text),)


def refreshed_problems(motion: AxisMotion, ripples: Ripples) -> Iterator[tuple[ShiftedProblem, Vector]]:
    """The regressions of a log whose torque was read every so many rows, and was another one between, and of one where
    it is the mean over them; none where it changes from row to row.
    """
    rows = stair_of(motion.torque)
    for width in (1.0, _TWICE) if rows > 1.0 else ():
        mean = Smoothing.mean_over(width * rows * motion.step_s)
        yield from motion.problems(ripples, SmoothedLog(SmoothedColumn.TORQUE, mean))


def lagged_position(motion: AxisMotion, ripples: Ripples, early: ShiftedFit) -> tuple[ShiftedFit, ...]:
    """The fit of an early torque in which the position is late by a low-pass of first order, where it leaves about as
    little: such a position is a little too small as well.
    """
    rate, lag_s, fit = np.gradient(motion.position, motion.step_s), 0.0, early
    for _ in range(_ROUNDS):
        lag_s -= fit.shift_s
        fit = fit_shifted(next(replace(motion, position=motion.position + lag_s * rate).problems(ripples))[0])
    return (fit,) if early.shift_s < 0.0 and fit.cost <= _POSSIBLE * early.cost else ()


def fits_of(problems: Problems, near: ShiftedFit) -> list[ShiftedFit]:
    """Their fits, with a shift near that of another."""
    return [fit_shifted(problem, near_s=near.shift_s) for problem, _ in problems]
