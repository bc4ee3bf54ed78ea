"""How an answer of the command stands to an error that was planted, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from itertools import combinations
from typing import Any

#: commanded torque never tells these from one another
ALIKE = {"viscous": frozenset({"viscous", "back_emf"})}
#: a gain that is off is every other number of the model being off alike
SCALED_BY_A_GAIN = frozenset({"inertia", "coulomb", "viscous", "back_emf", "static_unbalance"})
TOLD_AS_A_GAIN = (
    frozenset({"torque_gain"}),
    *(frozenset(two) for two in combinations(sorted(SCALED_BY_A_GAIN - {"back_emf"}), 2)),
)


class Outcome(Enum):
    """What an answer is worth to somebody who trusts it."""

    RIGHT = "right"
    CLASS = "class"
    #: the model says that it may be as far off, and the answer moves it back within that
    MOVED = "moved within its uncertainty"
    CANNOT_JUDGE = "cannot judge"
    SILENT = "silent"
    GUESS = "guess"
    FALSE_NAME = "FALSE NAME"
    FALSE_ALL_CLEAR = "FALSE ALL-CLEAR"
    NO_ANSWER = "no answer"


#: where the numbers of an effect stand in a model file
STANDS_AT = {
    "inertia": ("body.inertia.", "body.mass"),
    "coulomb": ("friction.coulomb",),
    "viscous": ("friction.viscous",),
    "static_unbalance": ("body.cog.",),
    "torque_gain": ("actuator.gain_error",),
}


@dataclass(frozen=True)
class Planted:
    """The effect whose number is off, by what factor, and effects that the rig has and its model has not: no false
    names.
    """

    effect: str
    factor: float
    beside: frozenset[str] = frozenset()

    @property
    def named_by(self) -> tuple[frozenset[str], ...]:
        """Sets of names any one of which tells it when all of it is named."""
        if self.effect == "torque_gain":
            return TOLD_AS_A_GAIN
        return tuple(frozenset({one}) for one in ALIKE.get(self.effect, {self.effect}))

    @property
    def true_names(self) -> frozenset[str]:
        """Every name that is not false."""
        scaled = SCALED_BY_A_GAIN if self.effect == "torque_gain" else frozenset()
        return self.beside.union(*self.named_by, scaled)


def outcome(said: Mapping[str, Any], planted: Planted) -> tuple[Outcome, str]:
    """The outcome of what `tests.rigs.told.ask` gives, and the reason in a few words."""
    if "error" in said:
        return Outcome.NO_ANSWER, str(said["error"])
    verdict = said["verdict"]
    named = {one["name"] for one in verdict["effects"] if one["status"] == "named"}
    guessed = {one["name"] for one in verdict["effects"]}
    false = sorted(named - planted.true_names)
    if false:
        return Outcome.FALSE_NAME, f"{' and '.join(false)}: not there"
    if verdict["verdict"] == "no_discrepancy":
        return Outcome.FALSE_ALL_CLEAR, _left(verdict)
    if verdict["verdict"] == "unusable_data":
        return Outcome.CANNOT_JUDGE, f"refused: {verdict['text']}"
    if verdict["verdict"] == "cannot_judge":
        return Outcome.CANNOT_JUDGE, _claim(verdict, planted)
    if any(names <= named for names in planted.named_by):
        return Outcome.RIGHT, ""
    told = guessed | {one["name"] for one in verdict["alternatives"]}
    if any(names & told for names in planted.named_by):
        return Outcome.CLASS, ""
    if guessed - planted.true_names:
        return Outcome.GUESS, _left(verdict)
    if any(_moves_back(one, planted) for one in verdict["recalibrated"]):
        return Outcome.MOVED, _left(verdict)
    if planted.effect in _not_shown(verdict):
        return Outcome.CANNOT_JUDGE, _claim(verdict, planted)
    return Outcome.SILENT, _left(verdict)


def _not_shown(verdict: Mapping[str, Any]) -> set[str]:
    return {one["name"] for one in verdict["would_not_show"]}


def _moves_back(one: Mapping[str, Any], planted: Planted) -> bool:
    """Whether a known number moved away from what was planted, by more than its interval."""
    beyond = one["high"] < one["from"] if planted.factor > 1.0 else one["low"] > one["from"]
    return beyond and one["path"].startswith(STANDS_AT[planted.effect])


def _claim(verdict: Mapping[str, Any], planted: Planted) -> str:
    """What the answer says of errors like the planted one."""
    if planted.effect in _not_shown(verdict):
        return "half or twice would not have shown, it says"
    sizes = [one["relative"] for one in verdict["smallest_shown"] if one["name"] == planted.effect]
    shown = min((size for size in sizes if size is not None), default=None)
    if shown is None:
        return "it would not have shown at any size"
    would = "would not have shown" if shown > abs(1.0 / planted.factor - 1.0) else "WRONG: should have shown"
    return f"{would}: from {shown:.0%}"


def _left(verdict: Mapping[str, Any]) -> str:
    """Size of the gap, and what the best answer leaves of it."""
    gap = verdict["gap"]
    if gap is None:
        return ""
    floor = gap["noise_floor"]
    return f"{gap['before'] / floor:.1f} floors, {gap['after'] / floor:.1f} left"
