"""Gains of one axis by search: the least predicted error among the loops that keep a margin on every case.

Predicted is the rms of the joint against its reference (`Errors`), worst over the cases: a disturbance torque that
walks by the break-away torque in a root second, and the sensors' noise. Loops must keep the asked disk margin on every
case, and stay stable with inertia, gyro and modes 30 % off either way and the torque a tick late, all at once.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.tuning.axis_cases import told_wrong
from gimbal_hil.knowledge.tuning.loops import (
    AxisDynamics,
    CascadeLaw,
    Disturbances,
    FilterResponse,
    Law,
    ObservedLaw,
    crossing_rad_s,
    disk_margin,
    errors,
    filter_response,
)
from gimbal_hil.knowledge.tuning.stability import largest_pole
from gimbal_hil.loop.control import ObservedJoint

#: share by which a plant may differ from its model with the loops still stable
WRONG_SHARE = 0.3
#: crossings that are tried, over the frequency at which delay and lag take a radian; ratios of the loops within
_CROSSINGS = np.geomspace(0.06, 1.0, 11)
_BANDWIDTHS = np.geomspace(0.15, 2.0, 10)
_POSITION_SHARES = (0.125, 1.0 / 6.0, 0.25, 1.0 / 3.0, 0.5, 0.7)
_CORNER_SHARES = (0.05, 0.1, 1.0 / 6.0, 0.25)
#: what delay and lag are taken for, at least
_LEAST_LAG_TICKS = 4.0
#: the position loop's integrator only takes out what a gyro's bias leaves: its corner, rad/s
_SLOW_CORNER_RAD_S = 1.0
#: refinement: factors on the numbers, up or down or not, each way; from so many beginnings, this far apart
_FINER = (1.12, 1.04)
_TURNS = tuple(turn for turn in itertools.product((-1, 0, 1), repeat=3) if any(turn))
_STARTS, _APART = 3, 1.5


@dataclass(frozen=True)
class TuningTask:
    """What the loops of one axis have to do."""

    step_s: float
    cases: tuple[AxisDynamics, ...]
    disturbances: Disturbances
    #: least disk margin of every case
    margin: float

    @property
    def frequencies(self) -> NDArray[np.float64]:
        """Where loops are looked at (rad/s), close together about modes."""
        top = 0.98 * math.pi / self.step_s
        w = [np.geomspace(0.05, top, 320)]
        for mode, damping, share in self.cases[0].modes:
            for at in (mode, mode / math.sqrt(1.0 - share)):
                w.append(at * (1.0 + max(damping, 1e-3) * np.linspace(-6.0, 6.0, 25)))
        found = np.unique(np.concatenate(w))
        return found[found < top]

    @property
    def quickest_rad_s(self) -> float:
        """Frequency at which held torque, delay and the gyro's lag take a radian of phase; a model that tells of
        neither does not mean that there is none.
        """
        one = self.cases[0]
        lag = 2.0 * one.gyro_damping / one.gyro_rad_s if one.gyro_rad_s > 0.0 else 0.0
        return 1.0 / max(0.5 * self.step_s + one.delay_s + lag, _LEAST_LAG_TICKS * self.step_s)


@dataclass(frozen=True)
class LoopFigures:
    """What is predicted of a law on the cases of a task, worst over them: disk margin, crossing of all loops at the
    torque (rad/s), error of the walking torque and the noise (rad rms); and whether it is stable on wrong plants too.
    """

    margin: float
    crossing_rad_s: float
    error_rad: float
    noise_rad: float
    stable_when_wrong: bool


def figures(laws: Sequence[Law], task: TuningTask) -> LoopFigures:
    """Figures of a law, given for each case of the task."""
    w = task.frequencies
    loops = [law.torque(w, case) for law, case in zip(laws, task.cases, strict=True)]
    found = [errors(law, case, w, task.disturbances) for law, case in zip(laws, task.cases, strict=True)]
    stable = all(largest_pole(law, case) < 1.0 for law, case in zip(laws, task.cases, strict=True))
    return LoopFigures(
        min(disk_margin(loop) for loop in loops) if stable else 0.0,
        max(crossing_rad_s(loop, w) for loop in loops),
        max(one.rms for one in found) if stable else math.inf,
        max(one.noise_rad for one in found) if stable else math.inf,
        stable and survives(laws, task),
    )


def survives(laws: Sequence[Law], task: TuningTask) -> bool:
    """Whether the loops stay stable on every wrong plant."""
    return all(
        largest_pole(law, wrong) < 1.0
        for law, case in zip(laws, task.cases, strict=True)
        for wrong in told_wrong(case, WRONG_SHARE, task.step_s)
    )


@dataclass(frozen=True)
class LoopChoice:
    """Numbers of a law, (position 1/s, rate crossing rad/s, third), and the laws they make on the cases."""

    numbers: tuple[float, float, float]
    laws: tuple[Law, ...]


#: laws on the cases for three numbers
Maker = Callable[[tuple[float, float, float]], tuple[Law, ...]]


def choose_cascade(task: TuningTask) -> LoopChoice | None:
    """Cascade of least predicted error, numbers (position kp 1/s, rate crossing rad/s, rate corner rad/s); None where
    no cascade keeps the margin.
    """
    return search(cascade_grid(task), lambda numbers: cascade_laws(numbers, task), task)


def cascade_grid(task: TuningTask) -> Iterator[tuple[float, float, float]]:
    """Numbers of cascades to begin a search with."""
    return (
        (position * crossing, crossing, corner * crossing)
        for crossing in task.quickest_rad_s * _CROSSINGS
        for position in _POSITION_SHARES
        for corner in _CORNER_SHARES
    )


def cascade_laws(numbers: tuple[float, float, float], task: TuningTask) -> tuple[Law, ...]:
    """The cascade of these numbers on each case; its torque per rate is that of the largest inertia."""
    position, crossing, corner = numbers
    kp = crossing * max(case.inertia_kg_m2 for case in task.cases)
    law = CascadeLaw(task.step_s, position, position * _SLOW_CORNER_RAD_S, kp, kp * corner)
    return (law,) * len(task.cases)


def choose_observed(task: TuningTask, joint: Callable[[float], ObservedJoint], delay_ticks: int) -> LoopChoice | None:
    """Observer and gains of least predicted error, numbers (position kp 1/s, rate crossing rad/s, observer's bandwidth
    rad/s); `joint` makes an observer of a bandwidth.
    """
    top, make = task.quickest_rad_s, observed_maker(task, joint, delay_ticks)
    grid = (
        (position * crossing, crossing, bandwidth)
        for bandwidth in bandwidths(task)
        for crossing in top * _CROSSINGS
        for position in _POSITION_SHARES
    )
    return search(grid, make, task)


def bandwidths(task: TuningTask) -> NDArray[np.float64]:
    """Bandwidths (rad/s) of observers to begin a search with."""
    return np.asarray(task.quickest_rad_s * _BANDWIDTHS)


def observed_maker(task: TuningTask, joint: Callable[[float], ObservedJoint], delay_ticks: int) -> Maker:
    """Laws of an observer on each case, which it knows but for the friction."""
    w, most = task.frequencies, max(case.inertia_kg_m2 for case in task.cases)
    known: dict[float, tuple[ObservedJoint, NDArray[np.float64], FilterResponse]] = {}

    def make(numbers: tuple[float, float, float]) -> tuple[Law, ...]:
        position, crossing, bandwidth = numbers
        if bandwidth not in known:
            one = joint(bandwidth)
            gains = one.gains()
            known[bandwidth] = one, gains, filter_response(one, gains, w)
        one, gains, filtered = known[bandwidth]
        return tuple(
            ObservedLaw(one, gains, position, crossing * most, case.inertia_kg_m2, delay_ticks, filtered)
            for case in task.cases
        )

    return make


def search(grid: Iterator[tuple[float, float, float]], make: Maker, task: TuningTask) -> LoopChoice | None:
    """Best of a grid, refined from several beginnings by steps in all numbers at once while that gains and the margins
    hold: along an edge of what they allow a step in one number alone leads nowhere.
    """
    w = task.frequencies
    ranked = sorted((error, numbers) for numbers in grid if (error := _error(make(numbers), task, w)) < math.inf)
    starts: list[tuple[float, float, float]] = []
    for _, numbers in ranked:
        if all(_apart(numbers, one) for one in starts) and survives(make(numbers), task):
            starts.append(numbers)
            if len(starts) == _STARTS:
                break
    if not starts:
        return None
    _, best = min(_refined(numbers, make, task) for numbers in starts)
    return LoopChoice(best, make(best))


def _apart(one: tuple[float, float, float], other: tuple[float, float, float]) -> bool:
    return any(max(a / b, b / a) > _APART for a, b in zip(one, other, strict=True))


def _refined(
    best: tuple[float, float, float], make: Maker, task: TuningTask
) -> tuple[float, tuple[float, float, float]]:
    """Error and numbers at the end of the way down from a beginning."""
    w, top = task.frequencies, task.quickest_rad_s
    least = _error(make(best), task, w)
    for factor in _FINER:
        gained = True
        while gained:
            gained = False
            for turn in _TURNS:
                tried = best[0] * factor ** turn[0], best[1] * factor ** turn[1], best[2] * factor ** turn[2]
                if tried[1] > top or tried[0] > _POSITION_SHARES[-1] * tried[1]:
                    continue
                laws = make(tried)
                error = _error(laws, task, w)
                if error < least * (1.0 - 1e-3) and survives(laws, task):
                    best, least, gained = tried, error, True
    return least, best


def _error(laws: Sequence[Law], task: TuningTask, w: NDArray[np.float64]) -> float:
    """Worst predicted error (rad rms), infinite where a case lacks the margin."""
    worst = 0.0
    for law, case in zip(laws, task.cases, strict=True):
        if disk_margin(law.torque(w, case)) < task.margin or largest_pole(law, case) >= 1.0:
            return math.inf
        worst = max(worst, errors(law, case, w, task.disturbances).rms)
    return worst
