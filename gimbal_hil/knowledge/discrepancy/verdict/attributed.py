"""Who says what of the numbers that a verdict moved: in the model files that it leaves, every one has a source and how
well it is known.
"""

from __future__ import annotations

from dataclasses import dataclass

from gimbal_hil.knowledge.discrepancy.judgement import Status
from gimbal_hil.knowledge.discrepancy.verdict.corrected import SOURCE
from gimbal_hil.knowledge.discrepancy.verdict.verdict import Verdict
from sim_backend.effects import CATALOGUE
from sim_backend.model import AntennaModel


@dataclass(frozen=True)
class FoundNumber:
    """Where a diagnosis puts a number, half of its 95 % interval, and how well it was known before."""

    value: float
    half_width: float
    known_within: float
    #: it is named as wrong, and not moved inside what was said of it
    named: bool


def attributed(before: AntennaModel, after: AntennaModel, verdict: Verdict | None = None) -> AntennaModel:
    """The model `after` a diagnosis of `before` with what is said of every number that it moved: one that, by its
    verdict, these data know better than was said before is identified, with half of its interval as uncertainty; any
    other has been moved inside what was said of it, and source and uncertainty stay as they were.
    """
    known = {} if verdict is None else found_numbers(before, verdict)
    for (axis, path), quantity in before.numbers.items():
        value = after.number(axis, path)
        if value == quantity.value:
            continue
        found = known.get((axis, path))
        if found is not None and found.half_width < found.known_within:
            after = after.with_number(axis, path, value, SOURCE, found.half_width)
        else:
            after = after.with_number(axis, path, value, quantity.source, before.uncertainty(axis, path))
    return after


def found_numbers(before: AntennaModel, verdict: Verdict) -> dict[tuple[str, str], FoundNumber]:
    """Numbers of a verdict by (axis, path); of those that it tells only the ones that it names count as told."""
    sure = {
        (effect["axis"], before.number_path(effect["axis"], parameter.path))
        for effect in verdict.effects
        for parameter in CATALOGUE[effect["name"]].parameters
        if effect["status"] == Status.NAMED.value and parameter.path is not None
    }
    found = {}
    for entry in verdict.recalibrated:
        place = entry["axis"], entry["path"]
        off = abs(float(entry["to"]) - before.number(*place)) if entry["named"] else 0.0
        half_width = 0.5 * abs(float(entry["high"]) - float(entry["low"]))
        named = entry["named"] and place in sure
        found[place] = FoundNumber(float(entry["to"]), half_width, max(float(entry["uncertainty"]), off), named)
    return found


__all__ = ["FoundNumber", "attributed", "found_numbers"]
