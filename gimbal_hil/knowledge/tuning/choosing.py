"""Gains of one axis by search: the least predicted error among the loops that keep a margin on every case.

Predicted is the rms of the joint against its reference (`Errors`), worst over the cases: a disturbance torque that
walks by the break-away torque in a root second, and the sensors' noise. Loops must keep the asked disk margin on every
case, and stay stable with inertia, gyro and modes 30 % off either way and the torque a tick late, all at once.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_discrete_are
from scipy.optimize import minimize

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
from gimbal_hil.loop.control import MEASURED_STATES, ObservedJoint

#: numbers of a design: the second one is a crossing (rad/s)
Numbers = tuple[float, ...]
#: an observer of a bandwidth and of the frequency above which disturbances are gusts (rad/s)
JointMaker = Callable[[float, float], ObservedJoint]

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
#: what an observer that expects gusts is tried with, over the same: its bandwidth, the corner of gusts, gains
_OBSERVED, _CORNERS = np.geomspace(0.5, 4.0, 5), np.array([0.08, 0.25, 0.8])
_POSITIONS, _OBSERVED_CROSSINGS = np.geomspace(0.08, 0.7, 5), np.geomspace(0.2, 1.0, 5)
#: refinement from so many beginnings, this far apart: size of the first simplex in logarithms, evaluations for each
#: number; what counts for a share of what is asked that is lacking, for the size of a pole and for any beyond one
_STARTS, _APART = 3, 1.5
_SIMPLEX, _EVALUATIONS = 0.2, 45
_SHORT, _POLES, _LEAST_SHORT = 20.0, 50.0, 0.01
#: the cost of numbers that make no law
_UNSOLVED = 1e3
#: so much worse than the best (in the error's logarithm) is not looked at any closer
_HOPELESS = 0.1


@dataclass(frozen=True)
class TuningTask:
    """What the loops of one axis have to do."""

    step_s: float
    cases: tuple[AxisDynamics, ...]
    disturbances: Disturbances
    #: least disk margin of every case
    margin: float
    #: torque by the sensors' noise (N m rms) beyond which loops count as worse
    most_noise_nm: float = math.inf

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
    """Numbers of a law, each in its design's order, and the laws they make on the cases."""

    numbers: Numbers
    laws: tuple[Law, ...]


#: laws on the cases for a design's numbers
Maker = Callable[[Numbers], tuple[Law, ...]]


def choose_cascade(task: TuningTask) -> LoopChoice | None:
    """Cascade of least predicted error, numbers (position kp 1/s, rate crossing rad/s, rate corner rad/s); None where
    no cascade keeps the margin.
    """
    return search(cascade_grid(task), lambda numbers: cascade_laws(numbers, task), task)


def cascade_grid(task: TuningTask) -> Iterator[Numbers]:
    """Numbers of cascades to begin a search with."""
    return (
        (position * crossing, crossing, corner * crossing)
        for crossing in task.quickest_rad_s * _CROSSINGS
        for position in _POSITION_SHARES
        for corner in _CORNER_SHARES
    )


def cascade_laws(numbers: Numbers, task: TuningTask) -> tuple[Law, ...]:
    """The cascade of these numbers on each case; its torque per rate is that of the largest inertia."""
    position, crossing, corner = numbers
    kp = crossing * max(case.inertia_kg_m2 for case in task.cases)
    law = CascadeLaw(task.step_s, position, position * _SLOW_CORNER_RAD_S, kp, kp * corner)
    return (law,) * len(task.cases)


def choose_observed(task: TuningTask, joint: JointMaker, delay_ticks: int) -> LoopChoice | None:
    """Observer and gains of least predicted error, numbers (position kp 1/s, rate crossing rad/s, observer's bandwidth
    rad/s, frequency above which disturbances are gusts rad/s); `joint` makes an observer of the last two.

    Gusts in the observer's filter do what loop transfer recovery does (Doyle and Stein 1981): they take back the phase
    that an observer costs which expects disturbances to last, and with it the stiffness at a given margin.
    """
    top, make = task.quickest_rad_s, observed_maker(task, joint, delay_ticks)
    grid = itertools.product(top * _OBSERVED, top * _CORNERS, top * _POSITIONS, top * _OBSERVED_CROSSINGS)
    turned = ((position, crossing, bandwidth, corner) for bandwidth, corner, position, crossing in grid)
    return search(turned, make, task)


def bandwidths(task: TuningTask) -> NDArray[np.float64]:
    """Bandwidths (rad/s) of observers to begin a search with, all of whose disturbances last."""
    return np.asarray(task.quickest_rad_s * _BANDWIDTHS)


def observed_maker(task: TuningTask, joint: JointMaker, delay_ticks: int) -> Maker:
    """Laws of an observer on each case, which it knows but for the friction."""
    w, most = task.frequencies, max(case.inertia_kg_m2 for case in task.cases)

    @lru_cache(maxsize=8)
    def filtered(bandwidth: float, corner: float) -> tuple[ObservedJoint, NDArray[np.float64], FilterResponse]:
        one = joint(bandwidth, corner)
        gains = steady_gains(one)
        return one, gains, filter_response(one, gains, w)

    def make(numbers: Numbers) -> tuple[Law, ...]:
        position, crossing, bandwidth, corner = numbers
        one, gains, response = filtered(bandwidth, corner)
        laws, answered = [], {}
        for inertia in (case.inertia_kg_m2 for case in task.cases):
            law = ObservedLaw(one, gains, position, crossing * most, inertia, delay_ticks)
            if inertia not in answered:
                answered[inertia] = law.accelerations(w, response)
            laws.append(replace(law, answered=answered[inertia]))
        return tuple(laws)

    return make


def steady_gains(joint: ObservedJoint) -> NDArray[np.float64]:
    """`ObservedJoint.gains` by a solver that is quick for every bandwidth, because a search asks a thousand times."""
    Q, R = joint.noises()
    rows = list(MEASURED_STATES)
    # both sensors in units of their noise: the spectra lie twenty powers of ten apart
    scale = np.sqrt(np.diag(R))
    measured = np.zeros((2, len(Q)))
    measured[(0, 1), rows] = 1.0 / scale
    P = solve_discrete_are(joint.transition().T, measured.T, Q, np.eye(2))
    return np.asarray(np.linalg.solve(P[np.ix_(rows, rows)] + R, P[rows]).T, dtype=np.float64)


def search(grid: Iterator[Numbers], make: Maker, task: TuningTask) -> LoopChoice | None:
    """Best of a grid, refined from several beginnings by the simplex method in the numbers' logarithms."""
    w = task.frequencies
    ranked = sorted((error, numbers) for numbers in grid if (error := _error(make(numbers), task, w)) < math.inf)
    starts: list[Numbers] = []
    for _, numbers in ranked:
        if all(_apart(numbers, one) for one in starts) and survives(make(numbers), task):
            starts.append(numbers)
            if len(starts) == _STARTS:
                break
    if not starts:
        return None
    _, best = min(_refined(numbers, make, task) for numbers in starts)
    return LoopChoice(best, make(best))


def _apart(one: Numbers, other: Numbers) -> bool:
    return any(max(a / b, b / a) > _APART for a, b in zip(one, other, strict=True))


def _refined(start: Numbers, make: Maker, task: TuningTask) -> tuple[float, Numbers]:
    """Error and numbers of the best loops on the way down from a beginning, of those that hold all that is asked."""
    best = [(_error(make(start), task, task.frequencies), start)]

    def cost(logarithms: NDArray[np.float64]) -> float:
        numbers = tuple(float(number) for number in np.exp(logarithms))
        try:
            laws = make(numbers)
        except np.linalg.LinAlgError:
            # numbers so far apart that their Riccati equation has no solution in double precision
            return _UNSOLVED
        error, short = _judged(laws, numbers, task)
        if short >= 1.0:
            return _SHORT * short
        found = math.log(error) + _SHORT * short
        if found > math.log(best[0][0]) + _HOPELESS:
            # wrong plants take most of the time, and would only make it worse
            return found
        unstable = max(
            largest_pole(law, plant)
            for law, case in zip(laws, task.cases, strict=True)
            for plant in told_wrong(case, WRONG_SHARE, task.step_s)
        )
        if unstable >= 1.0:
            return found + _SHORT * (_POLES * (unstable - 1.0) + _LEAST_SHORT)
        if short == 0.0 and error < best[0][0]:
            best[0] = error, numbers
        return found

    at = np.log(np.array(start))
    simplex = np.vstack([at, at + _SIMPLEX * np.eye(len(at))])
    minimize(
        cost,
        at,
        method="Nelder-Mead",
        options={"initial_simplex": simplex, "maxfev": _EVALUATIONS * len(at), "xatol": 5e-3, "fatol": 1e-4},
    )
    return best[0]


def _judged(laws: Sequence[Law], numbers: Numbers, task: TuningTask) -> tuple[float, float]:
    """Worst predicted error (rad rms), and by what share laws fall short of the margin and cross above what delay and
    lag allow. Zero: of nothing; from one on there is no error to tell.
    """
    poles = max(largest_pole(law, case) for law, case in zip(laws, task.cases, strict=True))
    if poles >= 1.0:
        return math.inf, poles
    w = task.frequencies
    margin = min(disk_margin(law.torque(w, case)) for law, case in zip(laws, task.cases, strict=True))
    found = max(_counted(law, case, task, w) for law, case in zip(laws, task.cases, strict=True))
    beyond = math.log(max(1.0, numbers[1] / task.quickest_rad_s))
    return found, min(max(0.0, 1.0 - margin / task.margin) + beyond, 1.0)


def _error(laws: Sequence[Law], task: TuningTask, w: NDArray[np.float64]) -> float:
    """Worst predicted error (rad rms), infinite where a case lacks the margin."""
    worst = 0.0
    for law, case in zip(laws, task.cases, strict=True):
        if disk_margin(law.torque(w, case)) < task.margin or largest_pole(law, case) >= 1.0:
            return math.inf
        worst = max(worst, _counted(law, case, task, w))
    return worst


def _counted(law: Law, case: AxisDynamics, task: TuningTask, w: NDArray[np.float64]) -> float:
    """Predicted error (rad rms) of one case, counted more where the sensors' noise shakes the torque too much."""
    found = errors(law, case, w, task.disturbances)
    return found.rms * max(1.0, found.noise_nm / task.most_noise_nm) ** 2
