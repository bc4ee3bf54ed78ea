"""How an answer of the command stands to an error that was planted, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

#: commanded torque never tells these from one another
ALIKE = {"viscous": frozenset({"viscous", "back_emf"})}
#: a gain that is off is every other number of the model being off alike
SCALED_BY_A_GAIN = frozenset({"inertia", "coulomb", "viscous", "back_emf", "static_unbalance"})
TOLD_AS_A_GAIN = (frozenset({"torque_gain"}), frozenset({"inertia", "coulomb"}))


class Outcome(Enum):
    """What an answer is worth to somebody who trusts it."""

    RIGHT = "right"
    CLASS = "class"
    CANNOT_JUDGE = "cannot judge"
    SILENT = "silent"
    GUESS = "guess"
    FALSE_NAME = "FALSE NAME"
    FALSE_ALL_CLEAR = "FALSE ALL-CLEAR"
    NO_ANSWER = "no answer"


@dataclass(frozen=True)
class Planted:
    """The effect whose number is off, and effects that the rig has and its model has not: no false names."""

    effect: str
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
    if verdict["verdict"] == "cannot_judge":
        hidden = verdict["next_experiment"]["separates"]
        right = planted.effect in hidden or planted.effect == "torque_gain"
        return Outcome.CANNOT_JUDGE, ("" if right else "for another reason: ") + ", ".join(hidden)
    if any(names <= named for names in planted.named_by):
        return Outcome.RIGHT, ""
    told = guessed | {one["name"] for one in verdict["alternatives"]}
    if any(names & told for names in planted.named_by):
        return Outcome.CLASS, ""
    if guessed - planted.true_names:
        return Outcome.GUESS, _left(verdict)
    return Outcome.SILENT, _left(verdict)


def _left(verdict: Mapping[str, Any]) -> str:
    """Size of the gap, and what the best answer leaves of it."""
    gap = verdict["gap"]
    if gap is None:
        return ""
    floor = gap["noise_floor"]
    return f"{gap['before'] / floor:.1f} floors, {gap['after'] / floor:.1f} left"
