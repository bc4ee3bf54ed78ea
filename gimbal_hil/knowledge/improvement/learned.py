"""What a diagnosis has taught about the numbers of a model: where they are, how far they may still be off, and by whom
that is known.

A number that is found beyond what was said of it was not known as well as was said: from then on it may be off by as
much as it was. The moments of a body are one such number: whoever took one of them from the wrong drawing took all.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

from gimbal_hil.knowledge.discrepancy import Status, Verdict
from sim_backend.effects import CATALOGUE
from sim_backend.model import AntennaModel

_SOURCE = "identified by gimbal-hil improve"
#: of a number that the next search begins from: known no better than it was off
_BEGUN_FROM = "found by gimbal-hil improve, to be searched on"
_MOMENTS, _PRODUCTS = (tuple(f"body.inertia.{c}" for c in of) for of in (("xx", "yy", "zz"), ("xy", "xz", "yz")))
_TENSOR = (*_MOMENTS, *_PRODUCTS)


@dataclass(frozen=True)
class _Found:
    """Where a diagnosis puts a number, half of its 95 % interval, and how well it was known before."""

    value: float
    half_width: float
    known_within: float
    #: it is named as wrong, and not moved inside what was said of it
    named: bool


def learned(base: AntennaModel, verdict: Verdict) -> AntennaModel:
    """The model that the next search begins from: `base` with the numbers that a verdict names as wrong where they were
    found, known no better than they turned out to be; a body's other moments with the one that was named. The same
    object where none is named.
    """
    named = {place: found for place, found in _found_of(base, verdict).items() if found.named}
    for axis in dict.fromkeys(axis for axis, _ in named):
        mine = {path: found for (at, path), found in named.items() if at == axis}
        off = {path: abs(found.value - base.number(axis, path)) for path, found in mine.items()}
        within = {path: max(off[path], one.half_width, base.uncertainty(axis, path)) for path, one in mine.items()}
        share = max((off[path] / _size(base, axis, path) for path in mine if path in _TENSOR), default=0.0)
        base = base.with_numbers(axis, {path: found.value for path, found in mine.items()}, _BEGUN_FROM, within)
        base = _as_unsure(base, axis, share, but=mine)
    return base


def attributed(before: AntennaModel, after: AntennaModel, verdict: Verdict | None = None) -> AntennaModel:
    """The model `after` a diagnosis of `before` with what is said of every number that it moved: one that, by its
    verdict, these data know better than was said before is identified, with half of its interval as uncertainty; any
    other has been moved inside what was said of it, and source and uncertainty stay as they were.
    """
    known = {} if verdict is None else _found_of(before, verdict)
    for (axis, path), quantity in before.numbers.items():
        value = after.number(axis, path)
        if value == quantity.value:
            continue
        found = known.get((axis, path))
        if found is not None and found.half_width < found.known_within:
            after = after.with_number(axis, path, value, _SOURCE, found.half_width)
        else:
            after = after.with_number(axis, path, value, quantity.source, before.uncertainty(axis, path))
    return after


def _found_of(before: AntennaModel, verdict: Verdict) -> dict[tuple[str, str], _Found]:
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
        found[place] = _Found(float(entry["to"]), half_width, max(float(entry["uncertainty"]), off), named)
    return found


def _size(model: AntennaModel, axis: str, path: str) -> float:
    """What a moment or a product of inertia is a share of: the moment itself, the largest one of its body."""
    largest = max(abs(model.number(axis, one)) for one in _MOMENTS)
    value = abs(model.number(axis, path)) if path in _MOMENTS else largest
    return value or largest or 1.0


def _as_unsure(model: AntennaModel, axis: str, share: float, but: Collection[str]) -> AntennaModel:
    """A model whose body may be off by a share in every moment but some; products count by all three together."""
    products = math.hypot(*(model.number(axis, one) for one in _PRODUCTS))
    for path in _TENSOR:
        value, stated = model.number(axis, path), model.uncertainty(axis, path)
        within = share * (abs(value) if path in _MOMENTS else products)
        if within > stated > 0.0 and path not in but:
            model = model.with_number(axis, path, value, model.numbers[axis, path].source, within)
    return model


__all__ = ["attributed", "learned"]
