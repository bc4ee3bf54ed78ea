"""Reports numbers that all changed by one factor as one torque gain."""

from __future__ import annotations

from collections.abc import Sequence

from firmware_protocol.json_object import Json

#: the number of each effect that a gain divides; all of an axis, or it is no gain
_DIVIDED = {"inertia": "inertia", "coulomb": "coulomb", "viscous": "viscous"}
GAIN = "torque_gain"


def as_one_gain(effects: Sequence[Json], known_to: float) -> tuple[list[Json], list[Json]]:
    """The changes, those of an axis that one gain makes as that gain, and alternatives that say what it stands for.

    Inertia, Coulomb level and viscous friction of an axis have to be told, and their factors must have a value in
    common: each lies within its interval and the share `known_to` within which the number before is known.
    """
    found, others = list(effects), []
    for axis in dict.fromkeys(entry["axis"] for entry in effects):
        own = {entry["name"]: entry for entry in effects if entry["axis"] == axis}
        if not _DIVIDED.keys() <= own.keys():
            continue
        numbers = [own[name]["parameters"][parameter] for name, parameter in _DIVIDED.items()]
        spans = [_factors(number, known_to) for number in numbers]
        low, high = max(span[0] for span in spans), min(span[1] for span in spans)
        if low > high:
            continue
        first = next(place for place, entry in enumerate(found) if entry["axis"] == axis and entry["name"] in _DIVIDED)
        divided = [own[name] for name in _DIVIDED]
        gain = {"value": 0.5 * (low + high) - 1.0, "low": low - 1.0, "high": high - 1.0, "unit": "1", "nominal": 0.0}
        least = min(divided, key=lambda entry: entry["probability"])
        entry = {**least, "name": GAIN, "parameters": {"gain_error": gain}, "made_of": [e["name"] for e in divided]}
        found = [
            entry if place == first else one for place, one in enumerate(found) if place == first or one not in divided
        ]
        reason = (
            "inertia, Coulomb level and viscous friction changed by one factor, which a gain of the drive does as well"
        )
        others += [
            {"name": name, "axis": axis, "instead_of": GAIN, "instead_of_axis": axis, "reason": reason}
            for name in _DIVIDED
        ]
    return found, others


def _factors(number: Json, known_to: float) -> tuple[float, float]:
    """By which gains a number may have been divided, the smallest and the largest."""
    if not number["nominal"] or not number["low"] > 0.0:
        return float("inf"), float("-inf")
    return number["nominal"] * (1.0 - known_to) / number["high"], number["nominal"] * (1.0 + known_to) / number["low"]
