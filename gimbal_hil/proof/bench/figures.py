"""A figure and how it is measured on a noisy machine: two things in turn, many times, the ratio pair by pair."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum


class GoalKind(StrEnum):
    """Which number of a figure has a target, and on which side of it."""

    RATIO_AT_LEAST = "ratio at least"
    RATIO_BELOW = "ratio below"
    VALUE_AT_LEAST = "value at least"
    VALUE_BELOW = "value below"


@dataclass(frozen=True)
class Goal:
    """What a figure is asked to reach."""

    kind: GoalKind
    limit: float

    def missed(self, value: float, ratio: float) -> bool:
        """Whether a figure with this value and ratio misses it."""
        number = ratio if self.kind in (GoalKind.RATIO_AT_LEAST, GoalKind.RATIO_BELOW) else value
        at_least = self.kind in (GoalKind.RATIO_AT_LEAST, GoalKind.VALUE_AT_LEAST)
        return number < self.limit if at_least else number >= self.limit

    def __str__(self) -> str:
        return f"{self.kind} {self.limit:g}"


@dataclass(frozen=True)
class Figure:
    """One line of the bench: a value, what it is compared with, and the spread over repeats."""

    name: str
    value: float
    unit: str
    reference: str
    #: value over reference, or how many times faster; median and extremes over the pairs
    ratio: float
    ratio_low: float
    ratio_high: float
    repeats: int
    target: Goal | None = None
    #: the ratio is how many times faster, else how many times longer
    faster: bool = False

    @property
    def cost(self) -> float:
        """Time over that of the reference, up to a factor that is always the same."""
        return 1.0 / self.ratio if self.faster else self.ratio

    @property
    def problem(self) -> str:
        """How the figure misses its target; empty where it does not, or has none."""
        if self.target is None or not self.target.missed(self.value, self.ratio):
            return ""
        return f"{self.name}: {self.value:.4g} {self.unit}, ratio {self.ratio:.3g}; target {self.target}"

    def as_row(self) -> list[str]:
        """The figure as table cells."""
        spread = f"{self.ratio_low:.3g} to {self.ratio_high:.3g}"
        target = "" if self.target is None else str(self.target)
        return [
            self.name,
            f"{self.value:.4g} {self.unit}",
            self.reference,
            f"{self.ratio:.3g}",
            spread,
            str(self.repeats),
            f"{target} MISSED" if self.problem else target,
        ]


def paired(
    work: Callable[[], object],
    reference: Callable[[], object],
    repeats: int = 9,
    clock: Callable[[], float] = time.process_time,
) -> tuple[list[float], list[float]]:
    """Times of `work` and `reference` in turn (s), one call of each first that is not counted.

    By default processor time of this process: what others do on the machine is no part of it, on a free one it is the
    same.
    """
    work()
    reference()
    ours: list[float] = []
    theirs: list[float] = []
    for _ in range(repeats):
        began = clock()
        work()
        between = clock()
        reference()
        theirs.append(clock() - between)
        ours.append(between - began)
    return ours, theirs


def times_faster(
    name: str,
    unit: str,
    per_call: float,
    ours: list[float],
    theirs: list[float],
    reference: str,
    reference_share: float,
    target: Goal | None = None,
) -> Figure:
    """A figure of time per piece of work, `per_call` pieces a call; `reference_share` is how many of ours one call of
    theirs stands for.
    """
    ratios = [(theirs_s / reference_share) / (ours_s / per_call) for ours_s, theirs_s in zip(ours, theirs, strict=True)]
    value = statistics.median(ours) / per_call
    middle = statistics.median(ratios)
    return Figure(
        name, value * 1e9, unit, reference, middle, min(ratios), max(ratios), len(ratios), target, faster=True
    )


def times_longer(
    name: str,
    unit: str,
    value: float,
    ours: list[float],
    theirs: list[float],
    reference: str,
    target: Goal,
) -> Figure:
    """A figure that costs some times what its reference does."""
    ratios = [a / b for a, b in zip(ours, theirs, strict=True)]
    return Figure(
        name, value, unit, reference, statistics.median(ratios), min(ratios), max(ratios), len(ratios), target
    )


def times_real_time(
    name: str, simulated_s: float, ours: list[float], theirs: list[float], reference: str, target: Goal | None = None
) -> Figure:
    """How many times faster than real time; the ratio is to the reference work of the same run, so that it holds on
    another machine.
    """
    speed = [simulated_s / s for s in ours]
    ratios = [ours_s / theirs_s for ours_s, theirs_s in zip(ours, theirs, strict=True)]
    return Figure(
        name,
        statistics.median(speed),
        "x real time",
        reference,
        statistics.median(ratios),
        min(ratios),
        max(ratios),
        len(ratios),
        target,
    )
