"""Motions that a search can move: laps of a few segments in which each axis goes smoothly to a place or swings about
where it is.

An experiment that tells two explanations apart needs few places and speeds, often, and not many once: what is searched
is one lap. Laps are drawn at random and varied, inside travel, rate, acceleration and time; motions are plan files.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.random import Generator

from firmware_protocol.json_object import Json
from gimbal_hil.knowledge.experiments import Experiment, experiment_of_plan, plan_from_document
from gimbal_hil.knowledge.improvement.budgets import Budgets
from gimbal_hil.loop.settings import DaemonSettings

#: name of the plan
MADE = "settle"
#: shares of rate, acceleration and travel that a motion is drawn in: loops overshoot
_RATE, _ACCELERATION, _TRAVEL = 0.9, 0.8, 0.9
#: how far an axis is turned either way where its travel allows more, rad: all round
_ROUND_RAD = math.pi
#: segments of a lap, its seconds, and those of all laps
_SEGMENTS, _LAP_S, _MOST_S = (2, 10), (1.5, 12.0), 32.0
#: of a move of least jerk: largest rate and acceleration over way / time and way / time^2
_PEAK_RATE, _PEAK_ACCELERATION = 1.875, 5.7735
#: steps of a change, as shares of a range
_STEPS = (0.3, 0.1, 0.03)
#: swings, Hz: up to where the scored band ends; the shortest segment, s
_SWING_HZ, _SHORTEST_S = (0.5, 25.0), 0.12
_REST_S, _TO_START_S = 0.5, 1.5


@dataclass(frozen=True)
class AxisRange:
    """What an axis may be asked for: places (rad), rate (rad/s), acceleration (rad/s^2)."""

    low_rad: float
    high_rad: float
    rate_rad_s: float
    acceleration_rad_s2: float

    def largest_swing(self, hz: float) -> float:
        """Largest amplitude (rad) at a frequency."""
        turns = 2.0 * math.pi * hz
        return min(self.rate_rad_s / turns, self.acceleration_rad_s2 / turns**2)

    def shortest_s(self, way_rad: float) -> float:
        """Shortest move of least jerk over a way."""
        rate, acceleration = self.rate_rad_s, self.acceleration_rad_s2
        return max(_PEAK_RATE * way_rad / rate, math.sqrt(_PEAK_ACCELERATION * way_rad / acceleration))


@dataclass(frozen=True)
class AxisMove:
    """What one axis does in a segment: go to a place, stay where it is, or swing about that."""

    to_rad: float | None = None
    swing_rad: float = 0.0
    swing_hz: float = 1.0


@dataclass(frozen=True)
class MotionSegment:
    """What each axis does, and how long."""

    moves: tuple[AxisMove, ...]
    over_s: float


@dataclass(frozen=True)
class LapMotion:
    """Laps of segments after one another, from the middle of both axes."""

    segments: tuple[MotionSegment, ...]
    laps: int = 1

    @property
    def most_laps(self) -> int:
        """How often the time of a motion allows its segments."""
        return max(1, int(_MOST_S / sum(one.over_s for one in self.segments)))


def ranges_of(settings: DaemonSettings, budgets: Budgets) -> tuple[AxisRange, ...]:
    """By axis: what the position loops follow, inside the budgets."""
    found = []
    for axis in settings.axis_names:
        low, high = (np.clip(end, -_ROUND_RAD, _ROUND_RAD) for end in budgets.travel_rad[axis])
        middle, half = 0.5 * (low + high), 0.5 * _TRAVEL * (high - low)
        section = settings.axes[axis]
        rates = [section.limits.rate_rad_s, section.position_loop.rate_limit_rad_s]
        accelerations = [section.limits.braking_rad_s2]
        if section.prefilter is not None and section.prefilter.rate_rad_s is not None:
            rates.append(section.prefilter.rate_rad_s)
            accelerations += [section.prefilter.acceleration_rad_s2 or math.inf]
        low, high = float(middle - half), float(middle + half)
        found.append(AxisRange(low, high, _RATE * min(rates), _ACCELERATION * min(accelerations)))
    return tuple(found)


def drawn(rng: Generator, ranges: Sequence[AxisRange], number: int) -> LapMotion:
    """A lap at random: by its number of slow ones, quick ones, and those that swing, in turn."""
    hurry = (0.15, 0.5, 0.9, 0.9)[number % 4]
    many = int(rng.integers(_SEGMENTS[0], 7))
    segments = [_segment(rng, ranges, hurry, swings=number % 4 == 3) for _ in range(many)]
    return _timed(_held(rng, segments) if rng.random() < 0.5 else segments, ranges)


def varied(rng: Generator, ranges: Sequence[AxisRange], parent: LapMotion) -> LapMotion:
    """A lap beside another: places, times and swings moved, segments put in, left out, exchanged or drawn anew."""
    segments = list(parent.segments)
    way, at = rng.random(), int(rng.integers(len(segments)))
    if way < 0.06:
        segments = _held(rng, segments)
    elif way < 0.15 and len(segments) < _SEGMENTS[1]:
        segments.insert(at, _segment(rng, ranges, 0.6, rng.random() < 0.3))
    elif way < 0.26 and len(segments) > _SEGMENTS[0]:
        del segments[at]
    elif way < 0.36:
        segments[at] = _segment(rng, ranges, float(rng.uniform(0.15, 1.0)), rng.random() < 0.3)
    elif way < 0.42:
        other = int(rng.integers(len(segments)))
        segments[at], segments[other] = segments[other], segments[at]
    else:
        by = float(rng.choice(_STEPS))
        segments = [
            _moved(rng, ranges, one, by) if rng.random() < 0.5 or k == at else one for k, one in enumerate(segments)
        ]
    return _timed(segments, ranges)


def experiment_of_motion(motion: LapMotion, text: str, settings: DaemonSettings, budgets: Budgets) -> Experiment:
    """A motion as an experiment."""
    document = plan_of(motion, text, settings, budgets)
    return experiment_of_plan(plan_from_document(document, MADE, settings.axis_names), settings.rate_hz, 1)


def plan_of(motion: LapMotion, text: str, settings: DaemonSettings, budgets: Budgets) -> Json:
    """A motion as a plan file, with the budgets as guards."""
    axes = settings.axis_names
    guards = {axis: _guard(settings, budgets, axis) for axis in axes}
    segments: list[Json] = [
        {"name": "rest", **{axis: {"mode": "position"} for axis in axes}, "duration_s": _REST_S},
        {"name": "to the start", **{axis: _to(0.0, _TO_START_S) for axis in axes}, "duration_s": _TO_START_S},
    ]
    at = [0.0] * len(axes)
    several = motion.laps > 1
    for lap, (number, segment) in product(range(1, motion.laps + 1), enumerate(motion.segments, 1)):
        does: Json = {}
        for i, (axis, move) in enumerate(zip(axes, segment.moves, strict=True)):
            if move.swing_rad > 0.0:
                swing = {"amplitude_rad": _rounded(move.swing_rad), "frequency_hz": _rounded(move.swing_hz)}
                does[axis] = {"mode": "position", "shape": "sine", "value_rad": _rounded(at[i]), **swing}
            elif move.to_rad is None:
                does[axis] = {"mode": "position", "value_rad": _rounded(at[i])}
            else:
                does[axis] = _to(move.to_rad, segment.over_s)
                at[i] = move.to_rad
        duration_s = _rounded(segment.over_s)
        name = f"segment {number}" + (f", lap {lap}" if several else "")
        segments.append({"name": name, **does, "duration_s": duration_s, "measure": True})
    for one in segments[1:]:
        one["guards"] = guards
    return {"schema": 1, "name": MADE, "text": text, "segments": segments}


def _to(place_rad: float, over_s: float) -> Json:
    return {"mode": "position", "shape": "smooth", "target_rad": _rounded(place_rad), "over_s": _rounded(over_s)}


def _guard(settings: DaemonSettings, budgets: Budgets, axis: str) -> dict[str, float]:
    limits = {"torque_nm": budgets.torque_nm[axis], "rate_rad_s": settings.axes[axis].limits.rate_rad_s}
    ends = zip(("low_rad", "high_rad"), budgets.travel_rad[axis], strict=True)
    return limits | {key: _rounded(end) for key, end in ends if math.isfinite(end)}


def _rounded(value: float) -> float:
    return float(f"{value:.5g}")


def _segment(rng: Generator, ranges: Sequence[AxisRange], hurry: float, swings: bool) -> MotionSegment:
    moves = []
    for one in ranges:
        place = float(rng.uniform(one.low_rad, one.high_rad)) * float(rng.choice([1.0, 1.0, 0.3, 0.05]))
        if swings and rng.random() < 0.7:
            hz = float(np.exp(rng.uniform(*np.log(_SWING_HZ))))
            moves.append(AxisMove(None, one.largest_swing(hz) * float(rng.uniform(0.2, 1.0)), hz))
        else:
            moves.append(AxisMove(place))
    return MotionSegment(tuple(moves), float(rng.uniform(0.3, 2.0)) / hurry)


def _held(rng: Generator, segments: Sequence[MotionSegment]) -> list[MotionSegment]:
    """One axis stays where it is: what does not help only takes time."""
    still = int(rng.integers(len(segments[0].moves)))
    moves = [tuple(AxisMove() if i == still else move for i, move in enumerate(one.moves)) for one in segments]
    return [replace(one, moves=its) for one, its in zip(segments, moves, strict=True)]


def _moved(rng: Generator, ranges: Sequence[AxisRange], segment: MotionSegment, by: float) -> MotionSegment:
    """Places, swings and time moved by about a share of their range."""
    moves = []
    for move, one in zip(segment.moves, ranges, strict=True):
        if move.to_rad is not None:
            place = move.to_rad + by * (one.high_rad - one.low_rad) * rng.normal()
            moves.append(AxisMove(float(np.clip(place, one.low_rad, one.high_rad))))
        else:
            hz = float(np.clip(move.swing_hz * np.exp(by * rng.normal()), *_SWING_HZ))
            moves.append(AxisMove(None, move.swing_rad * float(np.exp(by * rng.normal())), hz))
    return MotionSegment(tuple(moves), segment.over_s * float(np.exp(by * rng.normal())))


def _timed(segments: Sequence[MotionSegment], ranges: Sequence[AxisRange]) -> LapMotion:
    """No segment faster than rates and accelerations allow, and as long in all as is wanted."""
    total = sum(one.over_s for one in segments)
    factor = float(np.clip(total, *_LAP_S)) / total
    # a lap begins in the middle, or where the one before ended
    at: list[tuple[float, ...]] = []
    for i in range(len(ranges)):
        places = [place for one in segments if (place := one.moves[i].to_rad) is not None]
        at.append((0.0, *places[-1:]))
    found = []
    for segment in segments:
        over_s, moves = max(_SHORTEST_S, factor * segment.over_s), []
        for i, (move, one) in enumerate(zip(segment.moves, ranges, strict=True)):
            if move.to_rad is None:
                moves.append(replace(move, swing_rad=min(move.swing_rad, one.largest_swing(move.swing_hz))))
                continue
            over_s = max(over_s, one.shortest_s(max(abs(move.to_rad - place) for place in at[i])))
            moves.append(move)
            at[i] = (move.to_rad,)
        found.append(MotionSegment(tuple(moves), over_s))
    return LapMotion(tuple(found))


__all__ = [
    "MADE",
    "AxisMove",
    "AxisRange",
    "LapMotion",
    "MotionSegment",
    "drawn",
    "experiment_of_motion",
    "plan_of",
    "ranges_of",
    "varied",
]
