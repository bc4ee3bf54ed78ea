"""How well a number of a model file is known: how far it may be off, to either side, stated in the file or taken from
where the number comes from.

`uncertainty` beside a value is absolute in the value's unit (`0.002`) or relative (`10%`). A file may state one for all
its numbers (`uncertainty: 0.1%` at the top). Where neither is said, the first word of `source` that is known decides.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import BeforeValidator

#: relative uncertainty by a word in the source; the first such word in the text counts
RELATIVE_BY_WORD: dict[str, float] = {
    "measured": 0.05,
    "weighed": 0.05,
    "calibrated": 0.05,
    "identified": 0.05,
    "printed": 0.10,
    "published": 0.10,
    "data sheet": 0.10,
    "datasheet": 0.10,
    "catalogue": 0.10,
    "cad": 0.20,
    "drawing": 0.20,
    "inferred": 0.30,
    "computed": 0.30,
    "calculated": 0.30,
    "estimated": 0.30,
    "assumed": 0.50,
    "guessed": 0.50,
    "typical": 0.50,
}
#: who writes a number and no word about it means it: small, so that a number which is wrong is named and not moved in
#: silence
RELATIVE_WITHOUT_SOURCE = 0.02
#: the schema's own defaults (no offset, no lag) are no knowledge that may drift: what differs from them is a cause
DEFAULT_SOURCE = "default"

_WORD = re.compile("|".join(rf"\b{word}\b" for word in RELATIVE_BY_WORD), re.IGNORECASE)
_PERCENT = re.compile(r"\s*([0-9.]+(?:[eE][+-]?[0-9]+)?)\s*%\s*")
_EXPECTED = "an uncertainty is zero or more in the number's unit, or relative as in 10%"


@dataclass(frozen=True)
class Uncertainty:
    """How far a number may be off, to either side, in its unit or over its size."""

    amount: float
    relative: bool

    def absolute(self, size: float) -> float:
        """In the number's unit, for a number of this size (positive)."""
        return self.amount * size if self.relative else self.amount


def _as_uncertainty(raw: Any) -> Uncertainty:
    if isinstance(raw, Uncertainty):
        return raw
    matched = _PERCENT.fullmatch(raw) if isinstance(raw, str) else None
    try:
        amount = 0.01 * float(matched[1]) if matched else float(raw)
    except (TypeError, ValueError):
        raise ValueError(_EXPECTED) from None
    if (isinstance(raw, bool | str) and not matched) or not math.isfinite(amount) or amount < 0.0:
        raise ValueError(_EXPECTED)
    return Uncertainty(amount, matched is not None)


StatedUncertainty = Annotated[Uncertainty, BeforeValidator(_as_uncertainty)]


def relative_by_source(source: str | None) -> float:
    """How far off, over its value, a number with this source and no uncertainty of its own may be."""
    if source == DEFAULT_SOURCE:
        return 0.0
    found = _WORD.search(source or "")
    return RELATIVE_BY_WORD[found[0].lower()] if found else RELATIVE_WITHOUT_SOURCE
