"""Results of a bench as numbers: what became of each case, shares with their intervals, and how often told names are
right.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scipy.stats import binomtest

from tests.blind.score import (
    Outcome,
    demanded,
    near_numbers,
    numbers_found,
    outcome,
    parameter_errors,
    told_class,
    told_names,
)

#: floors at which a cause counts as small, medium and large; below the first it cannot be asked for
CLASSES = (("below 2 floors", 0.0), ("small (2 to 5)", 2.0), ("medium (5 to 15)", 5.0), ("large (over 15)", 15.0))
#: edges of the told probabilities' bins
PROBABILITY_BINS = (0.0, 0.5, 0.7, 0.85, 0.95, 0.99, 1.0)


@dataclass(frozen=True)
class CaseResult:
    """What the tables need of one case."""

    name: str
    outcome: Outcome
    verdict: str
    #: of the command, on the wall clock and of one processor
    seconds: float
    cpu_seconds: float
    #: name, axis, magnitude in floors
    hidden: tuple[tuple[str, str, float], ...]
    #: of them, known numbers that the model has wrong
    wrong_numbers: int
    #: name, axis, status
    named: tuple[tuple[str, str, str], ...]
    alternatives: tuple[tuple[str, str], ...]
    #: effect.parameter, relative error, whether the interval covers the truth
    parameters: tuple[tuple[str, float, bool], ...]
    #: name, axis, told probability, right
    told: tuple[tuple[str, str, float | None, bool], ...]
    #: told probability that the told causes and their alternatives hold what is hidden, and whether they do; none
    #: without one told
    told_class: tuple[float, bool] | None
    #: known numbers that were named though they are off only as far as the model says they may be
    near: tuple[tuple[str, str], ...]
    #: wrong number, named, named or recalibrated rightly
    numbers: tuple[tuple[str, bool, bool], ...]
    closed: float | None
    before_floors: float | None
    after_floors: float | None
    stated: str

    @property
    def kind(self) -> str:
        """First word of the name."""
        return self.name.split(".")[0]

    @property
    def least_floors(self) -> float:
        """Magnitude of the weakest hidden effect; a draw so small that it could not be read counts as nothing."""
        effects = self.hidden[: len(self.hidden) - self.wrong_numbers]
        return min((size if size == size else 0.0 for _, _, size in effects), default=0.0)

    @property
    def magnitude(self) -> str:
        """Class of the weakest hidden effect."""
        return [name for name, start in CLASSES if start == 0.0 or self.least_floors >= start][-1]

    @property
    def has_phantom(self) -> bool:
        """Whether a name that is not right was told."""
        return any(not right for _, _, _, right in self.told)


def case_result(name: str, truth: dict[str, Any], verdict: dict[str, Any], seconds: dict[str, float]) -> CaseResult:
    """One case, judged."""
    gap = verdict["gap"] or {}
    floor = gap.get("noise_floor")
    return CaseResult(
        name=name,
        outcome=outcome(truth, verdict),
        verdict=verdict["verdict"],
        seconds=seconds["wall"],
        cpu_seconds=seconds["cpu"],
        hidden=tuple((c["name"], c["axis"], float(c["magnitude_floors"])) for c in truth["causes"]),
        wrong_numbers=sum(c["number"] for c in truth["causes"]),
        named=tuple((e["name"], e["axis"], e["status"]) for e in verdict["effects"]),
        alternatives=tuple((a["name"], a["axis"]) for a in verdict["alternatives"]),
        parameters=tuple(parameter_errors(truth, verdict)),
        told=tuple(told_names(truth, verdict)),
        told_class=told_class(truth, verdict),
        near=tuple(
            sorted({(n, a) for n, a, _, _ in told_names(truth, verdict)} & near_numbers(truth) - demanded(truth))
        ),
        numbers=tuple(numbers_found(truth, verdict)),
        closed=gap.get("closed_fraction"),
        before_floors=gap["before"] / floor if floor else None,
        after_floors=gap["after"] / floor if floor else None,
        stated=truth["stated"],
    )


def results(folder: Path, names: Iterable[str]) -> list[CaseResult]:
    """Every case of the list that has been judged in a folder."""
    found = []
    for name in names:
        files = [folder / name / file for file in ("truth.json", "verdict.json", "seconds.json")]
        if all(file.exists() for file in files):
            truth, verdict, seconds = (json.loads(file.read_text(encoding="utf-8")) for file in files)
            found.append(case_result(name, truth, verdict, seconds))
    return found


@dataclass(frozen=True)
class Share:
    """So many of so many, with the 95 % interval of the share (Wilson)."""

    part: int
    whole: int

    @property
    def value(self) -> float:
        """The share; nan of nothing."""
        return self.part / self.whole if self.whole else float("nan")

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval."""
        if not self.whole:
            return 0.0, 1.0
        found = binomtest(self.part, self.whole).proportion_ci(method="wilson")
        return float(found.low), float(found.high)

    def __str__(self) -> str:
        if not self.whole:
            return "-"
        low, high = self.interval
        return f"{self.part}/{self.whole} ({100 * self.value:.1f} %, {100 * low:.0f} to {100 * high:.0f})"


def share(cases: Iterable[CaseResult], *outcomes: Outcome) -> Share:
    """How many of the cases ended so."""
    listed = list(cases)
    return Share(sum(c.outcome in outcomes for c in listed), len(listed))


@dataclass(frozen=True)
class Bin:
    """Names told with a probability in a range: the mean told, and the share that is right."""

    low: float
    high: float
    told: float
    right: Share


def reliability(cases: Iterable[CaseResult]) -> list[Bin]:
    """Told probability of each name against the share that is right, in bins that hold any."""
    return _binned([(p, right) for c in cases for _, _, p, right in c.told if p is not None])


def class_reliability(cases: Iterable[CaseResult]) -> list[Bin]:
    """The same of whole classes: 1 - `something_else` against the share in which a told name or an alternative is
    right.
    """
    return _binned([c.told_class for c in cases if c.told_class is not None])


def _binned(names: list[tuple[float, bool]]) -> list[Bin]:
    found = []
    for low, high in itertools.pairwise(PROBABILITY_BINS):
        mine = [(p, right) for p, right in names if low <= p < high or (high == 1.0 and p == 1.0)]
        if mine:
            found.append(Bin(low, high, sum(p for p, _ in mine) / len(mine), Share(sum(r for _, r in mine), len(mine))))
    return found
