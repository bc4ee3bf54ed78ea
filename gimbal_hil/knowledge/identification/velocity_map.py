"""From constant-speed segments to a velocity map: steady window, mean friction torque, its standard error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from gimbal_hil.knowledge.identification.averaging import Vector, mean_with_error, spread_about_lines, weighted_mean
from gimbal_hil.knowledge.identification.position_curve import PositionCurve, fit_position_curve
from gimbal_hil.knowledge.identification.steadiness import (
    SteadyRule,
    SteadyWindow,
    find_steady_window,
    mean_rate,
    settled_start,
)

#: plateaus whose speeds differ by less than this share are passes of one speed
_SAME_SPEED = 0.03
#: bristles have settled to a hundred-thousandth after so many lengths Ts / sigma0 of travel; more than this share of a
#: plateau never goes
_SETTLING_LENGTHS, _MOST_SETTLING = 12.0, 0.5
#: the rate's fluctuation is taken at steps of this time, s, about straight lines over so many of them: a rate loop is
#: faster than those
_JITTER_S, _JITTER_STEPS = 0.01, 50
#: a fluctuation beyond this share of the speed is no small one, and is not believed
_MOST_JITTER = 0.3
#: both directions must share this part of the travel before a position curve is fitted
_SHARED_TRAVEL = 0.7


@dataclass(frozen=True)
class Plateau:
    """One segment at constant commanded speed, one direction.

    `time_s`, `position` (encoder), `friction`: shape (n,). `friction` is the applied torque minus what the model's
    rigid body needs (gravity, base motion), centred on the samples; the acceleration term is left to the window's
    momentum balance. `inertia` is the axis' inertia, used for that balance. `settling_s` is what the loop needs from
    the first row on: zero where the rows were cut out of a steady motion.
    """

    label: str
    time_s: Vector
    position: Vector
    friction: Vector
    inertia: float
    settling_s: float = 0.0


@dataclass(frozen=True)
class VelocityPoint:
    """Mean friction torque at one joint rate; both signed. `passes` windows went into it, in which the rate fluctuated
    by `jitter` rms.
    """

    rate: float
    torque: float
    standard_error: float
    rate_error: float
    passes: int
    labels: tuple[str, ...]
    effective_samples: float
    jitter: float = 0.0


@dataclass(frozen=True)
class RejectedPlateau:
    """A segment that gave no point, and why."""

    label: str
    reason: str


@dataclass(frozen=True)
class VelocityMap:
    """Points in order of signed rate: one a pass in `passes`, pooled per speed and direction in `points`.

    The position curves are what was taken out; both are the same object when the directions share their travel.
    """

    points: tuple[VelocityPoint, ...]
    passes: tuple[VelocityPoint, ...]
    rejected: tuple[RejectedPlateau, ...]
    curve_positive: PositionCurve | None
    curve_negative: PositionCurve | None


def measure_velocity_map(
    plateaus: Sequence[Plateau],
    rule: SteadyRule | None = None,
    position_step: float | None = None,
    bristle_length: float = 0.0,
) -> VelocityMap:
    """Velocity map of one axis from its constant-speed segments.

    What the rigid body leaves over but depends on position alone (cogging, wrong centre of mass, cable) is fitted as a
    curve under all speeds and taken out first: one curve for both directions when they pass over the same stretch (then
    what is odd in position cancels and is measured), else one a direction, whose level where most plateaus pass cannot
    be told from friction. Windows that travel less than 100 times `position_step` (the encoder's) are refused;
    `bristle_length` is Ts / sigma0 as far as known: the travel over which friction settles is kept out of the position
    curve.
    """
    windows: list[tuple[Plateau, SteadyWindow]] = []
    rejected: list[RejectedPlateau] = []
    for plateau in plateaus:
        window = find_steady_window(plateau.time_s, plateau.position, rule)
        if window is None:
            rejected.append(
                RejectedPlateau(
                    plateau.label,
                    "no stretch of constant speed passes the trend and level tests (stick-slip or still settling)",
                )
            )
        elif (
            position_step is not None
            and abs(plateau.position[window.stop - 1] - plateau.position[window.start]) < 100.0 * position_step
        ):
            rejected.append(RejectedPlateau(plateau.label, "travels less than 100 encoder steps"))
        else:
            windows.append((plateau, window))
    curves = _position_curves(windows, bristle_length)
    passes = sorted(
        (_measure(plateau, window, curves[window.rate > 0.0], rule, bristle_length) for plateau, window in windows),
        key=lambda point: point.rate,
    )
    return VelocityMap(_pool(passes), tuple(passes), tuple(rejected), curves[True], curves[False])


def _position_curves(
    windows: Sequence[tuple[Plateau, SteadyWindow]], bristle_length: float
) -> dict[bool, PositionCurve | None]:
    """One curve when both directions pass over the same stretch, else one a direction (keyed by `rate > 0`)."""
    pieces: dict[bool, list[tuple[Vector, Vector]]] = {False: [], True: []}
    for plateau, window in windows:
        inside = slice(_settled_row(plateau, window, bristle_length), window.stop)
        pieces[window.rate > 0.0].append((plateau.position[inside], plateau.friction[inside]))
    ends = [
        (min(float(q.min()) for q, _ in side), max(float(q.max()) for q, _ in side)) for side in pieces.values() if side
    ]
    shared = min(high for _, high in ends) - max(low for low, _ in ends) if ends else 0.0
    whole = max(high for _, high in ends) - min(low for low, _ in ends) if ends else 0.0
    if len(ends) == 2 and shared > _SHARED_TRAVEL * whole:
        curve = fit_position_curve(pieces[False] + pieces[True])
        return {False: curve, True: curve}
    return {side: fit_position_curve(pieces[side]) for side in (False, True)}


def _settled_row(plateau: Plateau, window: SteadyWindow, bristle_length: float) -> int:
    """First row of the window by which the bristles, of a length `Ts / sigma0`, and the loop have had time to
    settle.
    """
    travelled = np.abs(plateau.position[: window.stop] - plateau.position[0])
    since = plateau.time_s[: window.stop] - plateau.time_s[0]
    enough = min(_SETTLING_LENGTHS * bristle_length, _MOST_SETTLING * float(travelled[-1]))
    long_enough = min(plateau.settling_s, _MOST_SETTLING * float(since[-1]))
    return max(window.start, int(np.argmax(travelled >= enough)), int(np.argmax(since >= long_enough)))


def _measure(
    plateau: Plateau, window: SteadyWindow, curve: PositionCurve | None, rule: SteadyRule | None, bristle_length: float
) -> VelocityPoint:
    window = replace(window, start=_settled_row(plateau, window, bristle_length))
    inside = slice(window.start, window.stop)
    friction = plateau.friction[inside]
    if curve is not None:
        friction = friction - curve.torque(plateau.position[inside])
    first, drift = settled_start(friction, rule)
    kept = replace(window, start=window.start + first)
    estimate = mean_with_error(friction[first:])
    momentum, momentum_error = _momentum(plateau, kept)
    # a drift that no trimming removes leaves the level uncertain by its uniform spread
    error = float(np.sqrt(estimate.standard_error**2 + momentum_error**2 + drift**2 / 12.0))
    return VelocityPoint(
        # of the rows whose torque counts: a loop that still comes to its speed was faster or slower before them
        mean_rate(plateau.time_s, plateau.position, kept.start, kept.stop),
        estimate.mean - momentum,
        error,
        window.rate_error,
        1,
        (plateau.label,),
        estimate.effective_samples,
        _jitter(plateau, kept),
    )


def _jitter(plateau: Plateau, window: SteadyWindow) -> float:
    """How much the joint rate fluctuates (rms) while a loop follows its gyro's noise: what the torque, added up, does
    to the inertia.

    Bristle damping takes part of that torque, which makes this too much; where a row is a whole block, the mean of the
    two torques that meet at it makes it a fifth too little. It is not more than the encoder shows, whose step is in
    that.
    """
    period = float(plateau.time_s[1] - plateau.time_s[0])
    rows = max(1, round(_JITTER_S / period))
    count = (window.stop - window.start) // rows // _JITTER_STEPS * _JITTER_STEPS
    if count == 0 or plateau.inertia <= 0.0:
        return 0.0
    inside = slice(window.start, window.start + count * rows)
    torque = plateau.friction[inside].reshape(count, rows).mean(axis=1)
    from_torque = spread_about_lines(_pieces(np.cumsum(torque - np.mean(torque)))) * rows * period / plateau.inertia
    steps = np.diff(plateau.position[inside][::rows])
    seen = spread_about_lines(_pieces(np.append(steps, steps[-1]))) / (rows * period)
    return float(min(from_torque, seen, _MOST_JITTER * abs(window.rate)))


def rate_jitter(time_s: Vector, position: Vector) -> float:
    """How much the rate of a steady motion fluctuates, rms, from the encoder alone, both (n,): for those who know no
    inertia.

    The scatter of travels of 10 ms (of a row where rows are longer: too little then) less what the encoder's step makes
    of it: the smallest difference between two travels of one row. Zero where fewer than fifty travels of 10 ms are
    there.
    """
    period = float(np.median(np.diff(time_s)))
    rows = max(1, round(_JITTER_S / period))
    travels = np.diff(position[::rows])
    count = len(travels) // _JITTER_STEPS * _JITTER_STEPS
    if count == 0:
        return 0.0
    apart = np.diff(np.unique(np.append(np.diff(position), 0.0)))
    # what is left of rounding is no step
    step = float(np.min(apart[apart > 1e-9 * np.ptp(position)], initial=np.inf))
    if not np.isfinite(step):
        return 0.0
    # two positions, each rounded: twice the variance of one uniform rounding error
    left = spread_about_lines(_pieces(travels[:count])) ** 2 - step**2 / 6.0
    return float(np.sqrt(max(left, 0.0))) / (rows * period)


def _pieces(values: Vector) -> Vector:
    return values.reshape(-1, _JITTER_STEPS)


def _momentum(plateau: Plateau, window: SteadyWindow) -> tuple[float, float]:
    """Mean torque that went into speeding up over the window, `inertia (v_end - v_start) / T`, and its error.

    End speeds are slopes over a twentieth of the window each.
    """
    length = max(8, (window.stop - window.start) // 20)
    speeds, variance = [], 0.0
    for part in (slice(window.start, window.start + length), slice(window.stop - length, window.stop)):
        t = plateau.time_s[part] - float(np.mean(plateau.time_s[part]))
        q = plateau.position[part] - float(np.mean(plateau.position[part]))
        slope = float(t @ q / (t @ t))
        speeds.append(slope)
        variance += float(np.var(q - slope * t)) / float(t @ t)
    span = float(plateau.time_s[window.stop - 1] - plateau.time_s[window.start])
    return plateau.inertia * (speeds[1] - speeds[0]) / span, plateau.inertia * float(np.sqrt(variance)) / span


def _pool(passes: Sequence[VelocityPoint]) -> tuple[VelocityPoint, ...]:
    """Passes of one speed and direction become one point; the scatter between them is part of its error."""
    group, groups = 0, []
    for index, point in enumerate(passes):
        if index and (point.rate - passes[index - 1].rate) > _SAME_SPEED * abs(point.rate):
            group += 1
        groups.append(group)
    pooled = []
    for _, members in groupby(zip(groups, passes, strict=True), key=lambda pair: pair[0]):
        points = [point for _, point in members]
        if len(points) == 1:
            pooled.append(points[0])
            continue
        smallest = 1e-6 * max(abs(point.torque) for point in points) + 1e-15
        torque = weighted_mean(
            np.array([p.torque for p in points]), np.array([max(p.standard_error, smallest) for p in points])
        )
        rate = float(np.mean([p.rate for p in points]))
        labels = tuple(label for p in points for label in p.labels)
        pooled.append(
            replace(
                points[0],
                rate=rate,
                torque=torque.mean,
                standard_error=torque.standard_error,
                passes=len(points),
                labels=labels,
                effective_samples=sum(p.effective_samples for p in points),
                jitter=float(np.mean([p.jitter for p in points])),
            )
        )
    return tuple(pooled)
