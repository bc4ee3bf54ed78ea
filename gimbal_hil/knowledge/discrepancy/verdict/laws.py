"""Laws as a verdict reports them: what they act on, over which variables, in which form, and how well that is known."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from firmware_protocol.json_object import Json
from gimbal_hil.knowledge.discrepancy.judgement import Result
from gimbal_hil.knowledge.discrepancy.laws import Curve, DescribedLaw
from gimbal_hil.pages.report import between
from sim_backend.model import UNIT_OF, UNIT_OVER


def laws_of(result: Result) -> tuple[dict[str, object], ...]:
    """Entries of `laws` in verdict.json."""
    return () if result.described is None else tuple(_entry(result, law) for law in result.described.laws)


def _entry(result: Result, law: DescribedLaw) -> dict[str, object]:
    curve, linear = law.curve, result.model.is_linear
    entry = curve.entry(linear)
    curves = ("knots", "values", "forward", "backward", "low", "high")
    told = (*curves, "direction_travel", "slack", "softness", "memory_s")
    return {
        "axis": curve.shape.axis,
        "acts_on": curve.shape.acts_on.value,
        "variables": [one.value for one in curve.shape.over],
        "by_direction": curve.shape.by_direction,
        "form": "curve" if law.formula is None else law.formula.text,
        "looks_like": [] if law.formula is None else [law.formula.phrase, *law.formula.alike],
        "unit": entry["unit"],
        "variable_units": [UNIT_OVER[one][linear] for one in curve.shape.over],
        "parameters": {key: entry[key] for key in told if key in entry}
        if law.formula is None
        else law.formula.numbers(linear),
        "held_out_gain": round(law.gain, 4),
        "best_control_gain": round(law.control, 4),
    }


def told_laws(result: Result) -> tuple[str, str]:
    """What the gap looks like, a line for each law, and how that is known."""
    if result.described is None:
        return "", ""
    looks, known = [], []
    for law in result.described.laws:
        curve, linear = law.curve, result.model.is_linear
        over, unit = curve.shape.over[0], UNIT_OVER[curve.shape.over[0]][linear]
        low, high = curve.knots[0][0], curve.knots[0][-1]
        size = _largest(curve, UNIT_OF[curve.shape.acts_on][linear])
        form = "" if law.formula is None else f", in the form of {law.formula.phrase}"
        looks.append(f"It looks like {curve.shape.text}: up to {size}{form}.")
        outside = (
            " and held constant outside"
            if law.formula is None
            else f": {law.formula.text}, {_numbers(law.formula.numbers(linear))}"
        )
        known.append(
            f"Seen from {low:.3g} to {high:.3g} {unit} of {over.value.replace('_', ' ')}{outside}. It takes "
            f"{law.gain:.0%} of the squares on rows that had no part in it.{_as_well(law)}"
        )
    return "\n".join(looks), " ".join(known)


def _largest(curve: Curve, unit: str) -> str:
    """The size of a curve where it is largest, with its band there."""
    values, low, high = (np.asarray(one, float).ravel() for one in (curve.values, curve.low, curve.high))
    at = int(np.argmax(np.abs(values)))
    ends = abs(low[at]), abs(high[at])
    return between(abs(values[at]), min(ends), max(ends), unit)


def _numbers(numbers: Mapping[str, Json]) -> str:
    """`k 1.8 N m/rad^3 (1.7 to 1.9), edge 0.3 rad`."""
    told = (f"{name} {between(one['value'], one['low'], one['high'], one['unit'])}" for name, one in numbers.items())
    return ", ".join(told)


def _as_well(law: DescribedLaw) -> str:
    """That it need not have this form, where others fit these data as well: the record lists them."""
    count = 0 if law.formula is None else len(law.formula.alike)
    if not count:
        return ""
    return f" {count} other form{'s fit' if count > 1 else ' fits'} these data as well (looks_like in verdict.json)."
