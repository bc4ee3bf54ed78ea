"""What the numbers of a torque column leave open of the torque: its zeros, its steps, its extremes.

A zero says no more than that a torque was smaller than what the column shows: less than a step of one that was cut off
towards zero, less than the band in which a drive or a logger has none. A torque whose highest and lowest places are all
flat, to the last of many digits, is no series of measurements but what a median left of one. The regression is made for
each such reading of the column that fits about as well; one that fits clearly better takes its place.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from gimbal_hil.knowledge.estimation import ShiftedFit, fit_shifted
from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.axis_motion import AxisMotion
from gimbal_hil.knowledge.identification.estimate import DataWarning, Determination, Estimate, settle
from gimbal_hil.knowledge.identification.other_columns import stair_of
from gimbal_hil.knowledge.identification.position_ripple import OverPosition

#: a torque has few steps where its largest is fewer of them than this; its numbers are whole ones to this share of one
_FEW_STEPS, _WHOLE = 200.0, 1e-3
#: another reading is possible where the squares that are left, a row that was not made up, are at most so many times
#: those of the plain one, and certain where they are at most this share of them
_POSSIBLE, _CERTAIN = 1.5, 0.5
#: zeros are more than chance from this share of the rows on, and make up a column up to this one
_FEWEST_ZEROS, _MOST_ZEROS = 0.005, 0.8
#: bands without torque that are tried, in units of the torque that all but one in twenty of the zeros need, and how
#: often the best of them is refined
_BANDS, _MOST_OF_THEM, _REFINED = (0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8), 0.95, 6
#: rounds in which a column made up from its own fit settles
_ROUNDS = 5
#: lengths of a median, rows; extremes that are no plateau are a smaller share of all of these many in a column behind
#: one
_MEDIANS, _POINTED, _FEWEST_EXTREMES = (3, 5, 7, 9, 11, 15, 19, 25, 33, 41, 51), 0.6, 30
_MEDIAN_TO_SIGMA = 1.4826
#: a torque that bends by less than so many of its last digits from row to row may rest where it turns back
_ROUGH = 3.0

Ripples = tuple[OverPosition, ...]


@dataclass(frozen=True)
class OtherTorque:
    """A motion with a torque that its column may have been made of, the squares that its regression leaves against the
    plain one's, what a reader must know of it, and whether the column alone says it.
    """

    motion: AxisMotion
    left: float
    finding: DataWarning
    is_seen: bool = False

    @property
    def is_certain(self) -> bool:
        """Whether it takes the place of the plain reading."""
        return self.left <= _CERTAIN and not self.is_seen

    @property
    def took_much(self) -> bool:
        """Whether what the column shows took a part of the torque that the log clearly misses."""
        return self.left <= _CERTAIN and self.is_seen

    @property
    def is_told(self) -> bool:
        """Whether a reader has to know of it."""
        return self.is_certain or self.is_seen


def other_torques(motion: AxisMotion, ripples: Ripples) -> list[OtherTorque]:
    """Readings of the torque column that leave about as little as the best, that first; behind them those before a
    median, which are never taken for certain.
    """
    plain = fit_shifted(next(motion.problems(ripples))[0])
    zeros = sorted(_readings(motion, ripples, plain), key=lambda one: one.left)
    most = _POSSIBLE * (zeros[0].left if zeros and zeros[0].is_certain else 1.0)
    return [*(one for one in zeros if one.left <= most), *_before_medians(motion, ripples, plain)]


def with_room(offset: Estimate, torque: Vector) -> Estimate:
    """An offset beside a torque (n,) of few steps: it was rounded to them, or always down, or always up."""
    room = 0.5 * step_of(torque)
    if room <= 0.0 or offset.verdict is Determination.NOT_IDENTIFIED:
        return offset
    interval = replace(offset.interval, low=offset.interval.low - room, high=offset.interval.high + room)
    return settle(offset.name, offset.fitted, interval, offset.unit, offset.prior, offset.experiment, offset.reason)


def step_of(torque: Vector) -> float:
    """The step of whole ones of which a torque (n,) has few; zero for a finer one."""
    levels = np.unique(torque)
    step = float(np.min(np.diff(levels))) if len(levels) > 2 else 0.0
    most = float(np.max(np.abs(torque)))
    if step <= 0.0 or most > _FEW_STEPS * step:
        return 0.0
    counts = torque / step
    return step if np.all(np.abs(counts - np.round(counts)) < _WHOLE * (1.0 + np.abs(counts))) else 0.0


def _readings(motion: AxisMotion, ripples: Ripples, plain: ShiftedFit) -> Iterator[OtherTorque]:
    """Each way in which a column may have got its zeros."""
    torque, unit = motion.torque, "N" if motion.rule.linear else "N m"
    sizes, zeros = np.abs(torque), torque == 0.0
    step = step_of(torque)
    if step > 0.0:
        text = (
            f"the torque column has only whole steps of {step:.3g} {unit} and fits the motion better as cut off "
            "towards zero than as rounded: half a step was added, and a zero may be anything below one; a log of more "
            "digits says more"
        )
        cut = _made_up(motion, ripples, plain, (0.5 * step, step), DataWarning("torque_cut_off", text))
        yield cut
        # of few steps what is lost is no noise: it goes with the motion
        for to_step, left in ((np.trunc, cut.left), (np.round, 1.0)):
            other, fit = _before(motion, ripples, plain, partial(_to_steps, step, to_step))
            yield OtherTorque(other, max(left, _cost(fit) / max(_cost(plain), 1e-300)), cut.finding)
    if not _FEWEST_ZEROS <= float(np.mean(zeros)) <= _MOST_ZEROS:
        return
    least = float(np.min(sizes[~zeros]))
    rows = f"{np.count_nonzero(zeros)} of {len(torque)} rows of the torque column are zero"
    if least > step:
        text = (
            f"{rows}, and no other is below {least:.3g} {unit}: the motion asks for some torque in them, so a zero was "
            "read as anything below that; a log without this band says more"
        )
        yield _made_up(motion, ripples, plain, (0.0, least), DataWarning("torque_dead_band", text))
    if step == 0.0:
        bands = _bands_of(motion, ripples, plain)
        text = (
            f"{rows}, and the motion asks for about {bands[0]:.3g} {unit} more in all others: they fit it better "
            "behind a band of that width without torque, which was put back; a log without this band says more"
        )
        for band in dict.fromkeys(bands):
            yield _made_up(motion, ripples, plain, (band, band), DataWarning("torque_dead_band", text))


def _to_steps(step: float, to_step: Callable[[Vector], Vector], torque: Vector) -> Vector:
    return step * to_step(torque / step)


def _bands_of(motion: AxisMotion, ripples: Ripples, plain: ShiftedFit) -> tuple[float, float, float]:
    """The width of the band that a torque lost on both sides of zero, as its motion likes it best, and the least and
    the largest that leave about as little.
    """
    needed = np.abs(motion.torque_of(plain, ripples)[motion.torque == 0.0])
    usual = float(np.quantile(needed, _MOST_OF_THEM))

    def left(band: float) -> float:
        return _cost(_filled(motion, ripples, plain, (band, band))[1])

    tried = {share * usual: left(share * usual) for share in _BANDS}
    for _ in range(_REFINED):
        places = sorted(tried)
        at = places.index(min(tried, key=lambda band: tried[band]))
        for beside in {places[max(0, at - 1)], places[min(len(places) - 1, at + 1)]} - {places[at]}:
            middle = float(np.sqrt(beside * places[at]))
            tried[middle] = left(middle)
    best = min(tried, key=lambda band: tried[band])
    alike = [band for band in sorted(tried) if tried[band] <= _POSSIBLE * tried[best]]
    return best, alike[0], alike[-1]


def _cost(fit: ShiftedFit) -> float:
    """Squares that are left, a row."""
    return fit.cost / max(len(fit.residual), 1)


def _made_up(
    motion: AxisMotion, ripples: Ripples, plain: ShiftedFit, widths: tuple[float, float], finding: DataWarning
) -> OtherTorque:
    other, fit = _filled(motion, ripples, plain, widths)
    return OtherTorque(other, _cost(fit) / max(_cost(plain), 1e-300), finding)


def _filled(
    motion: AxisMotion, ripples: Ripples, fit: ShiftedFit, widths: tuple[float, float]
) -> tuple[AxisMotion, ShiftedFit]:
    """The motion with `widths` (what each torque other than zero lost, what a zero may be either way) put back, and its
    fit: a zero is what the fit to the other rows expects between those bounds, in turns with it (as censored data are
    treated; Dempster, Laird and Rubin 1977).
    """
    lost, zero_to = widths
    zeros = motion.torque == 0.0
    torque = motion.torque + lost * np.sign(motion.torque)
    for _ in range(_ROUNDS):
        asked = motion.torque_of(fit, ripples)
        scatter = _MEDIAN_TO_SIGMA * float(np.median(np.abs((torque - asked)[~zeros]))) + 1e-12 * zero_to
        torque = np.where(zeros, _expected(asked, scatter, zero_to), torque)
        filled = replace(motion, torque=torque, made_up=zeros)
        fit = fit_shifted(next(filled.problems(ripples))[0], near_s=fit.shift_s)
    return filled, fit


def _expected(asked: Vector, scatter: float, most: float) -> Vector:
    """Mean of what is normal about `asked` (n,) with this scatter, between -most and most."""
    from scipy.special import log_ndtr

    # by symmetry about zero the lower bound is the nearer one: tails of the other side underflow
    low, high = (-most + np.abs(asked)) / scatter, (most + np.abs(asked)) / scatter
    with np.errstate(divide="ignore", under="ignore", over="ignore"):
        inside = log_ndtr(-low) + np.log1p(-np.exp(log_ndtr(-high) - log_ndtr(-low)))
        density = np.exp(-0.5 * low**2 - 0.5 * np.log(2.0 * np.pi) - inside)
        density -= np.exp(-0.5 * high**2 - 0.5 * np.log(2.0 * np.pi) - inside)
    mean = np.abs(asked) - scatter * np.nan_to_num(density, posinf=np.inf)
    return np.asarray(np.sign(asked) * np.clip(mean, -most, most))


def _before_medians(motion: AxisMotion, ripples: Ripples, plain: ShiftedFit) -> list[OtherTorque]:
    """The motion as it may have been before a median over some rows was taken of its torque, for each length that
    leaves nearly least; none where the torque's extremes are those of measurements.
    """
    from scipy.ndimage import median_filter

    rounded_or_held = step_of(motion.torque) > 0.0 or stair_of(motion.torque) > 1.0
    if rounded_or_held or not _has_flat_extremes(motion.torque):
        return []

    def median(rows: int, torque: Vector) -> Vector:
        return np.asarray(median_filter(torque, rows, mode="nearest"))

    tried = []
    for rows in _MEDIANS:
        other, fit = _before(motion, ripples, plain, partial(median, rows))
        tried.append((fit.cost, rows, other))
    least = min(plain.cost, min(cost for cost, _, _ in tried))
    alike = [one for one in tried if one[0] <= _POSSIBLE * least]
    if not alike:
        return []
    # between the shortest and the longest of them numbers go one way
    alike = alike if len(alike) < 3 else [alike[0], min(alike, key=lambda one: one[0]), alike[-1]]
    text = (
        "the torque column comes again to its last digit wherever it turns back, as what a median over some rows "
        f"leaves does ({' or '.join(str(rows) for _, rows, _ in alike[:3])} rows?): the intervals hold the numbers "
        "with it and without; a log that was not filtered says more"
    )
    finding = DataWarning("torque_median", text)
    # what was taken back stands for what was lost, and is known to itself at best
    cost, rows, last = alike[-1]
    alike.append((cost, rows, replace(last, torque=2.0 * last.torque - motion.torque)))
    return [OtherTorque(other, cost / max(plain.cost, 1e-300), finding, True) for cost, _, other in alike]


def _before(
    motion: AxisMotion, ripples: Ripples, fit: ShiftedFit, done: Callable[[Vector], Vector]
) -> tuple[AxisMotion, ShiftedFit]:
    """The motion as it may have been before something was `done` to its torque, and its fit: what that takes from the
    torque that the fit asks for was taken from the logged one.
    """
    other = motion
    for _ in range(_ROUNDS):
        asked = motion.torque_of(fit, ripples)
        other = replace(motion, torque=motion.torque + asked - done(asked))
        fit = fit_shifted(next(other.problems(ripples))[0], near_s=fit.shift_s)
    return other, fit


def _has_flat_extremes(torque: Vector) -> bool:
    """Whether a torque (n,) stays for a row or more where it turns back, as no measured one of fine steps does."""
    levels, steps = np.unique(torque), np.diff(torque)
    if len(levels) < 2 or np.mean(np.abs(np.diff(steps))) < _ROUGH * np.min(np.diff(levels)):
        # so smooth beside its last digit that any column rests there
        return False
    moving = steps[steps != 0.0]
    turns = np.count_nonzero(moving[1:] * moving[:-1] < 0.0)
    pointed = np.count_nonzero(steps[1:] * steps[:-1] < 0.0)
    return bool(turns >= _FEWEST_EXTREMES and pointed < _POINTED * turns)
