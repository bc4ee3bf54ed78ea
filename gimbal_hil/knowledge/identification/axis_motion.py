"""The regression of one axis as problems of least squares: motion and torque behind the same filters."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from gimbal_hil.knowledge.estimation import ShiftedFit, ShiftedProblem
from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.least_squares import Matrix
from gimbal_hil.knowledge.identification.position_ripple import OverPosition
from gimbal_hil.knowledge.identification.smoothed_log import SmoothedLog

#: torque may be logged this much early or late, s or rows, whichever is more
_MOST_SHIFT_S, _MOST_SHIFT_ROWS = 0.06, 8.0
#: rows this many times faster than the slowest that count give the same numbers, or the interval holds both; so few
#: rows say nothing
_SLOW_TOO, _FEWEST_ROWS = 20.0, 200
#: motion is differentiated behind a filter this many times the band of the fit
_WIDER = 5.0
#: and rows of this many times the band say as much as finer ones
_FINE = 16.0


@dataclass(frozen=True)
class RigidAxisRule:
    """How the regression is filtered: band of the fit, and what is dropped at each end.

    Motion is differentiated behind a zero-phase filter at five times `bandwidth_hz`; then torque and every regressor
    pass the same zero-phase filter at `bandwidth_hz`. The first and last `edge_periods / bandwidth_hz` seconds go, and
    so do rows slower than `slowest_share` of the top speed: there the sign of the speed says nothing about the
    friction. With `time_stated` torque and position have the times that their columns say; with `per_direction` each
    direction has its own viscous and Coulomb friction; `linear` says in which units the numbers are told.
    """

    bandwidth_hz: float
    edge_periods: float = 1.0
    slowest_share: float = 0.01
    time_stated: bool = False
    per_direction: bool = False
    linear: bool = False


def regression_rule(period_s: float, time_stated: bool = False, linear: bool = False) -> RigidAxisRule:
    """The rule for rows of this period: 20 Hz, or a tenth of the highest frequency that they hold."""
    return RigidAxisRule(min(20.0, 0.05 / period_s), time_stated=time_stated, linear=linear)


@dataclass(frozen=True)
class AxisMotion:
    """What was logged of one axis, (n,) each: `torque` held over the sample, `known` sampled, from the positions; rows
    whose torque was `made_up` are witnesses of nothing. Where friction grows with what position takes of the torque,
    that is the `load`, sampled; where it falls off with speed, `creep_speed` is where that has fallen to 37 %.
    """

    time_s: Vector
    position: Vector
    torque: Vector
    known: Vector
    rule: RigidAxisRule
    made_up: NDArray[np.bool_] | None = None
    load: Vector | None = None
    creep_speed: float | None = None

    @property
    def step_s(self) -> float:
        """Period of the rows."""
        return float(np.median(np.diff(self.time_s)))

    def middle(self, rows: int) -> AxisMotion:
        """At most so many rows from the middle of the log, at a rate that the band of the fit allows."""
        every = max(1, int(1.0 / (_FINE * self.rule.bandwidth_hz * self.step_s)))
        count = min(rows, len(self.time_s) // every)
        first = (len(self.time_s) - count * every) // 2
        part = slice(first, first + count * every)
        # a torque is held over the longer row by its mean, a position is read where that begins
        return replace(
            self,
            time_s=self.time_s[part][::every],
            position=self.position[part][::every],
            torque=self.torque[part].reshape(count, every).mean(axis=1),
            known=self.known[part][::every],
            made_up=None if self.made_up is None else np.any(self.made_up[part].reshape(count, every), axis=1),
            load=None if self.load is None else self.load[part][::every],
        )

    def problems(
        self, ripples: tuple[OverPosition, ...] = (), smoothed: SmoothedLog | None = None
    ) -> Iterator[tuple[ShiftedProblem, Vector]]:
        """The regression at each choice of band and slowest rows, the rule's own first, with the rate (n,) of all
        rows; of a log whose columns are taken to be `smoothed`.
        """
        rule = self.rule
        for band in (rule.bandwidth_hz, 0.5 * rule.bandwidth_hz):
            problem, rate, inside = self._problem(band, ripples, smoothed)
            thin = max(1, int(1.0 / self.step_s / (2.5 * band)))
            for slowest in (rule.slowest_share, _SLOW_TOO * rule.slowest_share):
                rows = np.flatnonzero(inside & (np.abs(rate) >= slowest * float(np.max(np.abs(rate)))))[::thin]
                own = band == rule.bandwidth_hz and slowest == rule.slowest_share
                if own or len(rows) >= _FEWEST_ROWS:
                    yield replace(problem, rows=rows), rate

    def torque_of(self, fit: ShiftedFit, ripples: tuple[OverPosition, ...] = ()) -> Vector:
        """The torque (n,) that a fit of this motion asks for in each row, from motion in the band of the fit."""
        step = self.step_s
        smooth, rate = self._smooth(self.rule.bandwidth_hz)
        at_samples = np.stack(self._asked(smooth, rate, ripples), axis=1) @ fit.solution - self.known
        # a row is in force from its sample to the next, and was logged late by the shift
        places = np.arange(len(at_samples), dtype=np.float64)
        return np.asarray(np.interp(places + 0.5 - fit.shift_s / step, places, at_samples))

    def rate(self) -> Vector:
        """The rate (n,) behind the filter of the first regression."""
        return self._smooth(_WIDER * self.rule.bandwidth_hz)[1]

    def _smooth(self, cutoff_hz: float, smoothed: SmoothedLog | None = None) -> tuple[Vector, Vector]:
        """Position and rate behind a low-pass, (n,) each."""
        position = self.position if smoothed is None else smoothed.sharp(self.position, self.step_s)
        smooth = sosfiltfilt(_low_pass(cutoff_hz, 1.0 / self.step_s), position)
        return smooth, np.asarray(CubicSpline(self.time_s, smooth)(self.time_s, 1))

    def _asked(self, smooth: Vector, rate: Vector, ripples: tuple[OverPosition, ...]) -> tuple[Vector, ...]:
        """What each unknown is multiplied by, (n,) each: the numbers, what is over position, friction under load and at
        creep.
        """
        numbers = _columns(smooth, rate, self.step_s, self.rule.per_direction)
        over = (column for ripple in ripples for column in ripple.columns(smooth))
        loaded = () if self.load is None else (np.abs(self.load) * _mean_sign(rate),)
        creep = () if self.creep_speed is None else (np.exp(-np.abs(rate) / self.creep_speed) * _mean_sign(rate),)
        return *numbers, *over, *loaded, *creep

    def _problem(
        self, band: float, ripples: tuple[OverPosition, ...], smoothed: SmoothedLog | None
    ) -> tuple[ShiftedProblem, Vector, np.ndarray]:
        """One of a band, its rate (n,), and which rows are far enough from both ends."""
        step, rule = self.step_s, self.rule
        smooth, rate = self._smooth(_WIDER * band, smoothed)
        narrow = _low_pass(band, 1.0 / step)
        asked = self._asked(smooth, rate, ripples)
        columns: Matrix = np.stack([sosfiltfilt(narrow, one) for one in asked], axis=1)
        target, load = sosfiltfilt(narrow, centred_torque(self.torque)), sosfiltfilt(narrow, self.known)
        edge = rule.edge_periods / band
        if smoothed is not None:
            columns, load = smoothed.as_torque(columns, step), smoothed.as_torque(load, step)
            edge = max(edge, 1.0 / smoothed.smoothing.half_hz)
        inside = np.zeros(len(target), dtype=bool)
        margin = int(round(edge / step))
        inside[margin : len(target) - margin] = True
        inside &= True if self.made_up is None else ~self.made_up
        most = max(_MOST_SHIFT_S, _MOST_SHIFT_ROWS * step)
        return ShiftedProblem(step, target, load, columns, np.flatnonzero(inside), band, most), rate, inside


def centred_torque(torque: Vector) -> Vector:
    """Held torque seen at the samples: mean of the two values that meet at t_k, shape (n,).

    Row k acts over [t_k, t_k+1), so at t_k the mean of rows k-1 and k is in force; row k alone would be half a sample
    late and look like a delay or a flexibility.
    """
    return np.asarray(np.concatenate([torque[:1], 0.5 * (torque[1:] + torque[:-1])]))


def _columns(smooth: Vector, rate: Vector, step: float, per_direction: bool) -> tuple[Vector, ...]:
    """What each number is multiplied by, (n,) each: its mean over the two samples that meet at t_k, as torque's."""
    acceleration, mean_rate = _mean_slope(rate, step), _mean_slope(smooth, step)
    sign = _mean_sign(rate)
    if not per_direction:
        return acceleration, mean_rate, sign, np.ones_like(rate)
    forward, backward = np.maximum(mean_rate, 0.0), np.minimum(mean_rate, 0.0)
    return acceleration, forward, backward, 0.5 * (1.0 + sign), -0.5 * (1.0 - sign)


def _mean_slope(values: Vector, step: float) -> Vector:
    return np.asarray(np.gradient(values, step))


def _mean_sign(rate: Vector) -> Vector:
    """Mean of sign(rate) from the sample before to the sample after, the rate straight between them: a reversal counts
    where it is, not at the next row.
    """
    change = np.diff(rate)
    between = np.where(change != 0.0, np.diff(np.abs(rate)) / np.where(change == 0.0, 1.0, change), np.sign(rate[1:]))
    return np.concatenate([between[:1], 0.5 * (between[1:] + between[:-1]), between[-1:]])


def _low_pass(cutoff_hz: float, rate_hz: float) -> Matrix:
    return np.asarray(butter(4, min(cutoff_hz / (0.5 * rate_hz), 0.95), output="sos"))
