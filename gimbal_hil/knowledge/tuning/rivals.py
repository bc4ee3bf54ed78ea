"""Controllers of other designs for one axis, synthesised for the same task as `tune` and under the same margin.

Each design has a few numbers, which the same search chooses: least predicted error among those that keep the disk
margin on every case and survive the wrong plants. Riccati equations are solved by scipy.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, solve_continuous_are, solve_discrete_are
from scipy.signal import cont2discrete

from gimbal_hil.knowledge.tuning.choosing import (
    LoopChoice,
    Maker,
    Numbers,
    TuningTask,
    bandwidths,
    cascade_grid,
    search,
)
from gimbal_hil.knowledge.tuning.loops import SampledLaw

Matrix = NDArray[np.float64]
#: (A, B, C, D)
System = tuple[Matrix, Matrix, Matrix, Matrix]
#: damping of a notch's zeros and poles
_NOTCH = (0.08, 0.8)
#: robust stabilisation asks for so much less than the best there is
_SLACK = 1.1
#: corner of the position loop's integrator, which only takes out what a gyro's bias leaves (rad/s)
_SLOW_CORNER_RAD_S = 1.0
#: natural frequencies that a regulator is tried with, over the frequency at which delay and lag take a radian
_REGULATORS = np.geomspace(0.05, 0.8, 14)


def notched(task: TuningTask) -> LoopChoice | None:
    """The cascade with a notch at the resonance of every mode; numbers as `choose_cascade`."""
    T, w, most = task.step_s, task.frequencies, max(case.inertia_kg_m2 for case in task.cases)
    notch = _static(1.0)
    for mode, _, share in task.cases[0].modes:
        at = mode / math.sqrt(1.0 - share)
        shallow, deep = _NOTCH
        one = _second_order((1.0, 2.0 * shallow * at, at * at), (1.0, 2.0 * deep * at, at * at))
        notch = _series(notch, _sampled(one, T))

    def make(numbers: Numbers) -> tuple[SampledLaw, ...]:
        position, crossing, corner = numbers
        kp = crossing * most
        return _laws(task, w, _series(_cascade(T, position, position * _SLOW_CORNER_RAD_S, kp, kp * corner), notch))

    return search(cascade_grid(task), make, task)


def loop_shaped(task: TuningTask) -> LoopChoice | None:
    """H-infinity loop shaping: the cascade's PI shapes the loop, robust stabilisation of the normalised coprime factors
    (McFarlane and Glover 1992) adds what the delay and the lag take. Numbers as `choose_cascade`.
    """
    T, w, one, most = task.step_s, task.frequencies, task.cases[0], max(case.inertia_kg_m2 for case in task.cases)
    lag_s = one.delay_s + 0.5 * T + (2.0 * one.gyro_damping / one.gyro_rad_s if one.gyro_rad_s else 0.0)
    delay = _first_order((-0.5 * lag_s, 1.0), (0.5 * lag_s, 1.0))

    def make(numbers: Numbers) -> tuple[SampledLaw, ...]:
        position, crossing, corner = numbers
        # torque to rate plus position times its gain, and the PI before it
        plant = _second_order((1.0 / most, position / most), (1.0, 0.0, 0.0))
        shape = _first_order((crossing * most, crossing * most * corner), (1.0, 0.0))
        stabiliser = robust_stabiliser(_series(_series(shape, delay), plant))
        one_input = _series(_sampled(stabiliser, T), _sampled(shape, T))
        both = _static(np.array([[position, 1.0]]))
        return _laws(task, w, _series(both, one_input))

    return search(cascade_grid(task), make, task)


def robust_stabiliser(plant: System) -> System:
    """Controller of an error for a strictly proper plant: largest radius of perturbed coprime factors, less slack."""
    A, B, C, _ = plant
    X = solve_continuous_are(A, B, C.T @ C, np.eye(B.shape[1]))
    Z = solve_continuous_are(A.T, C.T, B @ B.T, np.eye(len(C)))
    square = (_SLACK**2) * (1.0 + float(np.abs(np.linalg.eigvals(X @ Z)).max()))
    F, L = -B.T @ X, (1.0 - square) * np.eye(len(A)) + X @ Z
    gain = square * np.linalg.solve(L.T, Z @ C.T)
    # with positive feedback it is this one; of an error, minus it
    return A + B @ F + gain @ C, gain, -(B.T @ X), np.zeros((B.shape[1], len(C)))


@dataclass(frozen=True)
class Regulator:
    """Gains of a linear quadratic regulator on the estimates of an observer: 1/s and rad/s."""

    position_kp: float
    crossing: float


def regulator(natural_rad_s: float, step_s: float) -> Regulator:
    """The regulator of a sampled double integrator whose weights are one on the position and natural^-4 on the
    acceleration. Known delay is predicted over, so it takes none of the gains.
    """
    A, B = np.array([[1.0, step_s], [0.0, 1.0]]), np.array([[0.5 * step_s**2], [step_s]])
    Q, R = np.diag([1.0, 0.0]), np.array([[natural_rad_s**-4]])
    P = solve_discrete_are(A, B, Q, R)
    first, second = np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A)[0]
    return Regulator(float(first / second), float(second))


def linear_quadratic(make: Maker, task: TuningTask) -> LoopChoice | None:
    """LQG with integral action: the regulator on a Kalman filter that estimates the disturbance, which is taken off.
    `make` makes laws of an observer; numbers as `choose_observed`.
    """

    def bound(numbers: Numbers) -> Numbers:
        bandwidth, natural = numbers
        found = regulator(natural, task.step_s)
        return found.position_kp, found.crossing, bandwidth, math.inf

    grid = itertools.product(bandwidths(task), task.quickest_rad_s * _REGULATORS)
    best = search(grid, lambda numbers: make(bound(numbers)), task)
    return None if best is None else LoopChoice(bound(best.numbers), best.laws)


def as_array(laws: Sequence[SampledLaw]) -> Matrix:
    """Laws of two axes as `run_law` takes them, the shorter one filled up with states that stay zero."""
    size = max(len(law.A) for law in laws)
    found = np.zeros((len(laws), size + 1, size + 2))
    for place, law in zip(found, laws, strict=True):
        n = len(law.A)
        place[:n, :n], place[:n, size:] = law.A, law.B
        place[size, :n], place[size, size:] = law.C[0], law.D[0]
    return found


def _laws(task: TuningTask, w: Matrix, system: System) -> tuple[SampledLaw, ...]:
    """The same law on each case."""
    law = SampledLaw(task.step_s, *system)
    return (replace(law, answered=law.answers(w)),) * len(task.cases)


def _cascade(T: float, position: float, slow: float, rate_kp: float, rate_ki: float) -> System:
    """Position PI over rate PI, errors of position and rate to torque."""
    A = np.array([[1.0, 0.0], [rate_ki * T, 1.0]])
    B = np.array([[slow * T, 0.0], [rate_ki * T * position, rate_ki * T]])
    return A, B, np.array([[rate_kp, 1.0]]), np.array([[rate_kp * position, rate_kp]])


def _static(gain: float | Matrix) -> System:
    D = np.atleast_2d(gain)
    return np.zeros((0, 0)), np.zeros((0, D.shape[1])), np.zeros((len(D), 0)), D


def _first_order(num: Sequence[float], den: Sequence[float]) -> System:
    direct = num[0] / den[0]
    return (
        np.array([[-den[1] / den[0]]]),
        np.array([[1.0]]),
        np.array([[num[1] / den[0] - direct * den[1] / den[0]]]),
        np.array([[direct]]),
    )


def _second_order(num: Sequence[float], den: Sequence[float]) -> System:
    """A ratio of polynomials over one of second order with a leading one, in controllable form."""
    n2, n1, n0 = (0.0, *num)[-3:] if len(num) < 3 else num
    _, d1, d0 = den
    return (
        np.array([[0.0, 1.0], [-d0, -d1]]),
        np.array([[0.0], [1.0]]),
        np.array([[n0 - n2 * d0, n1 - n2 * d1]]),
        np.array([[n2]]),
    )


def _series(first: System, second: System) -> System:
    """The second one on what the first one gives."""
    (A, B, C, D), (E, F, G, H) = first, second
    joined = block_diag(A, E)
    joined[len(A) :, : len(A)] = F @ C
    return joined, np.vstack([B, F @ D]), np.hstack([H @ C, G]), H @ D


def _sampled(system: System, step_s: float) -> System:
    found = cont2discrete(system, step_s, method="bilinear")
    return found[0], found[1], found[2], found[3]
