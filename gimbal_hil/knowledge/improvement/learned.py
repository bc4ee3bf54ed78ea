"""What a diagnosis has taught about the numbers of a model: where they are, how far they may still be off, and by whom
that is known.

A number that is found beyond what was said of it was not known as well as was said: from then on it may be off by as
much as it was. The moments of a body are one such number: whoever took one of them from the wrong drawing took all.
"""

from __future__ import annotations

import math
from collections.abc import Collection

from gimbal_hil.knowledge.discrepancy import Verdict, found_numbers
from sim_backend.model import MOMENTS, PRODUCTS, AntennaModel

#: of a number that the next search begins from: known no better than it was off
_BEGUN_FROM = "found by gimbal-hil improve, to be searched on"
_TENSOR = (*MOMENTS, *PRODUCTS)


def learned(base: AntennaModel, verdict: Verdict) -> AntennaModel:
    """The model that the next search begins from: `base` with the numbers that a verdict names as wrong where they were
    found, known no better than they turned out to be; a body's other moments with the one that was named. The same
    object where none is named.
    """
    named = {place: found for place, found in found_numbers(base, verdict).items() if found.named}
    for axis in dict.fromkeys(axis for axis, _ in named):
        mine = {path: found for (at, path), found in named.items() if at == axis}
        off = {path: abs(found.value - base.number(axis, path)) for path, found in mine.items()}
        within = {path: max(off[path], one.half_width, base.uncertainty(axis, path)) for path, one in mine.items()}
        share = max((off[path] / _size(base, axis, path) for path in mine if path in _TENSOR), default=0.0)
        base = base.with_numbers(axis, {path: found.value for path, found in mine.items()}, _BEGUN_FROM, within)
        base = _as_unsure(base, axis, share, but=mine)
    return base


def _size(model: AntennaModel, axis: str, path: str) -> float:
    """What a moment or a product of inertia is a share of: the moment itself, the largest one of its body."""
    largest = max(abs(model.number(axis, one)) for one in MOMENTS)
    value = abs(model.number(axis, path)) if path in MOMENTS else largest
    return value or largest or 1.0


def _as_unsure(model: AntennaModel, axis: str, share: float, but: Collection[str]) -> AntennaModel:
    """A model whose body may be off by a share in every moment but some; products count by all three together."""
    products = math.hypot(*(model.number(axis, one) for one in PRODUCTS))
    for path in _TENSOR:
        value, stated = model.number(axis, path), model.uncertainty(axis, path)
        within = share * (abs(value) if path in MOMENTS else products)
        if within > stated > 0.0 and path not in but:
            model = model.with_number(axis, path, value, model.numbers[axis, path].source, within)
    return model


__all__ = ["learned"]
