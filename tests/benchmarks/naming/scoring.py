"""What an answer is worth. The only place where it meets the truth."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tests.benchmarks.naming.tables import read_csv

#: from where on a tool says a name; what it holds less likely counts for its Brier score only
FIRM = 0.5
#: a wrong number that stands lower than this, in floors, need not be told
DEMANDED_FLOORS = 3.0
#: commanded torque cannot tell the members of a class apart on every motion: naming one for another is the right class
CLASSES = (
    {"viscous", "back_emf", "quadratic_drag", "temperature_viscosity"},
    {"coulomb", "stribeck", "presliding", "position_dependent_friction"},
    {"coulomb_asymmetry", "viscous_asymmetry", "torque_offset"},
    {"static_unbalance", "cable_spring", "cogging"},
    {"transport_delay", "actuator_lag", "structural_resonance", "backlash"},
    {"torque_gain", "inertia", "load_dependent_friction", "saturation"},
    {"gyro_bias", "gyro_scale", "gyro_misalignment"},
)
Pair = tuple[str, str]


@dataclass(frozen=True)
class Score:
    """One answer to one case."""

    task: str
    #: exactly what is hidden was named; or the classes that were named are those of what is hidden
    exact: bool
    of_class: bool
    #: names of nothing that is there
    false_names: int
    #: nothing was named, and whether that is right
    abstained: bool
    nameable: bool
    #: (probability, whether right) of everything that was told
    told: tuple[tuple[float, bool], ...]
    #: 1 - after^2 / before^2 on the challenge, over the axes; None without a prediction
    closed: float | None
    seconds: float
    answered: bool

    @property
    def good(self) -> bool:
        """Exact where something can be named, silent where not."""
        return self.exact if self.nameable else self.abstained


def score(truth: Path, case: Path, answer: Path, seconds: float) -> Score:
    """Judge what a tool left in `answer`; a tool that left nothing has not answered."""
    hidden = json.loads(truth.read_text())
    wanted, allowed = _wanted(hidden), _allowed(hidden)
    written = answer / "answer.json"
    said = json.loads(written.read_text()) if written.exists() else {"effects": []}
    told: dict[Pair, float] = {}
    for effect in said["effects"]:
        pair = (_folded(str(effect["name"])), str(effect["axis"]))
        told[pair] = max(told.get(pair, 0.0), min(max(float(effect["probability"]), 0.0), 1.0))
    firm = {pair for pair, probability in told.items() if probability >= FIRM}
    return Score(
        hidden["task"],
        bool(wanted) and wanted <= firm <= allowed,
        bool(wanted) and _classes_of(wanted) <= _classes_said(told) <= _classes_of(allowed),
        sum(pair not in allowed for pair in firm),
        written.exists() and not firm,
        bool(wanted),
        tuple((probability, pair in allowed) for pair, probability in told.items()),
        _closed(truth, case, answer),
        seconds,
        written.exists(),
    )


def _wanted(hidden: dict[str, Any]) -> set[Pair]:
    causes = [c for c in hidden["causes"] if c["inside"]]
    if any(not c["inside"] for c in hidden["causes"]):
        return set()
    return {
        (_folded(c["name"]), c["axis"]) for c in causes if not c["number"] or c["magnitude_floors"] >= DEMANDED_FLOORS
    }


def _allowed(hidden: dict[str, Any]) -> set[Pair]:
    akin = {(_folded(name), c["axis"]) for c in hidden["causes"] for name in c["akin"]}
    return akin | {(_folded(c["name"]), c["axis"]) for c in hidden["causes"] if c["inside"]}


def _folded(name: str) -> str:
    return "viscous" if name == "back_emf" else name


def _class(pair: Pair) -> tuple[frozenset[str], str]:
    name, axis = pair
    return next((frozenset(members) for members in CLASSES if name in members), frozenset({name})), axis


def _classes_of(pairs: set[Pair]) -> set[tuple[frozenset[str], str]]:
    return {_class(pair) for pair in pairs}


def _classes_said(told: dict[Pair, float]) -> set[tuple[frozenset[str], str]]:
    """Classes that a tool says: its members' probabilities count together, so that who cannot tell may say so."""
    total: dict[tuple[frozenset[str], str], float] = {}
    for pair, probability in told.items():
        total[_class(pair)] = total.get(_class(pair), 0.0) + probability
    return {one for one, probability in total.items() if probability >= FIRM}


def _closed(truth: Path, case: Path, answer: Path) -> float | None:
    path = answer / "torque.csv"
    if not path.exists():
        return None
    axes = json.loads((case / "case.json").read_text())["axes"]
    measured, known, said = np.load(truth.with_suffix(".npy")), read_csv(case / "challenge.csv"), read_csv(path)
    settled = slice(len(measured) // 20, -(len(measured) // 20))
    before = after = 0.0
    for k, axis in enumerate(axes):
        gap = (measured[:, k] - known[f"{axis}.torque_model"])[settled]
        before += float(np.mean(gap**2)) / float(np.mean(measured[settled, k] ** 2))
        after += float(np.mean((measured[:, k] - said[f"{axis}.torque"])[settled] ** 2)) / float(
            np.mean(measured[settled, k] ** 2)
        )
    return 1.0 - after / before


@dataclass(frozen=True)
class Tally:
    """All answers of one tool."""

    cases: int
    exact: float
    right_class: float
    #: share of the cases with a false name; and of those in which nothing is to be named
    false: float
    false_on_nothing: float
    #: share of silent answers among the cases that have a name (too shy) and that have none (right)
    silent_on_something: float
    silent_on_nothing: float
    brier: float
    #: mean of told probabilities minus share that was right: above zero the tool is too sure
    overconfidence: float
    closed_median: float
    seconds_median: float
    unanswered: int


def tally(scores: Sequence[Score]) -> Tally:
    """Shares over a tool's answers; NaN where there is nothing to take a share of."""
    something = [one for one in scores if one.nameable]
    nothing = [one for one in scores if not one.nameable]
    told = [pair for one in scores for pair in one.told]
    probabilities = np.array([probability for probability, _ in told])
    right = np.array([float(hit) for _, hit in told])
    closed = [one.closed for one in something if one.closed is not None]
    return Tally(
        len(scores),
        _share([one.exact for one in something]),
        _share([one.exact or one.of_class for one in something]),
        _share([one.false_names > 0 for one in scores]),
        _share([one.false_names > 0 for one in nothing]),
        _share([one.abstained for one in something]),
        _share([one.abstained for one in nothing]),
        float(np.mean((probabilities - right) ** 2)) if told else float("nan"),
        float(np.mean(probabilities) - np.mean(right)) if told else float("nan"),
        float(np.median(closed)) if closed else float("nan"),
        float(np.median([one.seconds for one in scores])) if scores else float("nan"),
        sum(not one.answered for one in scores),
    )


def _share(found: Sequence[bool]) -> float:
    return sum(found) / len(found) if found else float("nan")
