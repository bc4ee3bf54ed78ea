"""From constant-speed segments to a velocity map: steady window, mean friction torque, its standard error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from gimbal_hil.identification.averaging import Vector, mean_with_error, weighted_mean
from gimbal_hil.identification.position_curve import PositionCurve, fit_position_curve
from gimbal_hil.identification.steadiness import SteadyRule, SteadyWindow, find_steady_window, settled_start

#: plateaus whose speeds differ by less than this share are passes of one speed
_SAME_SPEED = 0.03
#: bristles have settled after so many lengths Ts / sigma0 of travel
_SETTLING_LENGTHS = 3.0
#: both directions must share this part of the travel before a position curve is fitted
_SHARED_TRAVEL = 0.7


@dataclass(frozen=True)
class Plateau:
    """One segment at constant commanded speed, one direction.

    `time_s`, `position` (encoder), `friction`: shape (n,). `friction` is the applied torque minus what the model's rigid body needs
    (gravity, base motion), centred on the samples; the acceleration term is left to the window's momentum balance. `inertia` is the
    axis' inertia, used for that balance.
    """

    label: str
    time_s: Vector
    position: Vector
    friction: Vector
    inertia: float


@dataclass(frozen=True)
class VelocityPoint:
    """Mean friction torque at one joint rate; both signed. `passes` windows went into it."""

    rate: float
    torque: float
    standard_error: float
    rate_error: float
    passes: int
    labels: tuple[str, ...]
    effective_samples: float


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
    plateaus: Sequence[Plateau], rule: SteadyRule | None = None, position_step: float | None = None, bristle_length: float = 0.0
) -> VelocityMap:
    """Velocity map of one axis from its constant-speed segments.

    What the rigid body leaves over but depends on position alone (cogging, wrong centre of mass, cable) is fitted as a curve under
    all speeds and taken out first: one curve for both directions when they pass over the same stretch (then what is odd in position
    cancels and is measured), else one a direction, whose level where most plateaus pass cannot be told from friction. Windows that
    travel less than 100 times `position_step` (the encoder's) are refused; `bristle_length` is Ts / sigma0 as far as known: the
    travel over which friction settles is kept out of the position curve.
    """
    windows: list[tuple[Plateau, SteadyWindow]] = []
    rejected: list[RejectedPlateau] = []
    for plateau in plateaus:
        window = find_steady_window(plateau.time_s, plateau.position, rule)
        if window is None:
            rejected.append(
                RejectedPlateau(
                    plateau.label, "no stretch of constant speed passes the trend and level tests (stick-slip or still settling)"
                )
            )
        elif position_step is not None and abs(plateau.position[window.stop - 1] - plateau.position[window.start]) < 100.0 * position_step:
            rejected.append(RejectedPlateau(plateau.label, "travels less than 100 encoder steps"))
        else:
            windows.append((plateau, window))
    curves = _position_curves(windows, bristle_length)
    passes = sorted(
        (_measure(plateau, window, curves[window.rate > 0.0], rule) for plateau, window in windows), key=lambda point: point.rate
    )
    return VelocityMap(_pool(passes), tuple(passes), tuple(rejected), curves[True], curves[False])


def _position_curves(windows: Sequence[tuple[Plateau, SteadyWindow]], bristle_length: float) -> dict[bool, PositionCurve | None]:
    """One curve when both directions pass over the same stretch, else one a direction (keyed by `rate > 0`)."""
    pieces: dict[bool, list[tuple[Vector, Vector]]] = {False: [], True: []}
    for plateau, window in windows:
        inside = slice(window.start, window.stop)
        position, friction = plateau.position[inside], plateau.friction[inside]
        settled = np.abs(position - position[0]) >= min(_SETTLING_LENGTHS * bristle_length, 0.5 * float(np.ptp(position)))
        pieces[window.rate > 0.0].append((position[settled], friction[settled]))
    ends = [(min(float(q.min()) for q, _ in side), max(float(q.max()) for q, _ in side)) for side in pieces.values() if side]
    shared = min(high for _, high in ends) - max(low for low, _ in ends) if ends else 0.0
    whole = max(high for _, high in ends) - min(low for low, _ in ends) if ends else 0.0
    if len(ends) == 2 and shared > _SHARED_TRAVEL * whole:
        curve = fit_position_curve(pieces[False] + pieces[True])
        return {False: curve, True: curve}
    return {side: fit_position_curve(pieces[side]) for side in (False, True)}


def _measure(plateau: Plateau, window: SteadyWindow, curve: PositionCurve | None, rule: SteadyRule | None) -> VelocityPoint:
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
    return VelocityPoint(window.rate, estimate.mean - momentum, error, window.rate_error, 1, (plateau.label,), estimate.effective_samples)


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
        torque = weighted_mean(np.array([p.torque for p in points]), np.array([max(p.standard_error, smallest) for p in points]))
        rate = float(np.mean([p.rate for p in points]))
        labels = tuple(label for p in points for label in p.labels)
        pooled.append(
            replace(points[0], rate=rate, torque=torque.mean, standard_error=torque.standard_error, passes=len(points), labels=labels,
                    effective_samples=sum(p.effective_samples for p in points))
        )  # fmt: skip
    return tuple(pooled)
