"""A formula after a curve: the shortest way to write what the curve says, among forms that engineers write."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from firmware_protocol.documents import LARGEST_NUMBER
from gimbal_hil.knowledge.discrepancy.inquiry import INTERVAL
from gimbal_hil.knowledge.discrepancy.laws.curve import DIGITS, SOURCE
from gimbal_hil.knowledge.discrepancy.laws.fitting import Written, foretold, polished, scales_of, scanned
from gimbal_hil.knowledge.discrepancy.laws.forms import LEVEL, SLOPE, FormNumber, NumberRole, beside, renamed, terms_of
from gimbal_hil.knowledge.discrepancy.laws.linear import FOLDS
from gimbal_hil.knowledge.discrepancy.laws.saying import Saying
from gimbal_hil.knowledge.discrepancy.laws.shape import LawShape
from gimbal_hil.knowledge.discrepancy.twin import Floats
from sim_backend.model import UNIT_OF, UNIT_OVER, LawKind, Over, dimension_of, unit_text

#: forms that are looked at closely, by how much they take; those that are asked what other stretches say; those that
#: get a second term; numbers of a formula at most
_CLOSELY, _FORETOLD, _TWO, _MOST_NUMBERS = 12, 7, 3, 8
#: nats of what they leave of other stretches within which two formulas are not told apart
_ALIKE = 3.0
#: draws of the folds for an interval
_DRAWS = 20


@dataclass(frozen=True)
class Formula:
    """A law as a formula: terms, inner numbers, scales, and the interval of all."""

    shape: LawShape
    written: Written
    scales: Floats
    low: Floats
    high: Floats
    #: phrases of other formulas that these data do not tell from it
    alike: tuple[str, ...] = ()

    @property
    def phrase(self) -> str:
        """What it looks like, in words."""
        return phrase_of(self.written)

    @property
    def roles(self) -> dict[str, NumberRole]:
        """What each of its own numbers does."""
        return {name: number.role for name, number in _named(self.written)}

    @property
    def text(self) -> str:
        """The formula as a model file has it."""
        shape = self.shape
        direction = "direction(turn)" if shape.direction_travel > 0.0 else "sign(rate)"
        slack = "slack, softness" if shape.softness else "slack"
        memory = {Over.HANGS_BACK: f"hangs_back({slack})", Over.RECENT_SPEED: "recent_speed(memory)"}
        variables = tuple(memory.get(over, over.value) for over in shape.over)
        names = renamed(self.written.terms)
        texts = [t.text(variables, direction, n) for t, n in zip(self.written.terms, names, strict=True)]
        return " + ".join(texts)

    def numbers(self, is_linear: bool) -> dict[str, dict[str, object]]:
        """Value, unit and interval of each number by its name."""
        shape, found = self.shape, {}
        unit = UNIT_OF[shape.acts_on][is_linear]
        for at, (name, number) in enumerate(_named(self.written)):
            over = UNIT_OVER[shape.over[number.of]][is_linear]
            words = {NumberRole.SCALE: (unit, number.over), NumberRole.WAVE: ("1", 1)}.get(number.role, (over, 0))
            found[name] = {
                "value": _rounded(_values(self.written, self.scales)[at]),
                "unit": _over(words[0], over, words[1]),
                "low": _rounded(self.low[at]),
                "high": _rounded(self.high[at]),
            }
        length = UNIT_OVER[Over.POSITION][is_linear]
        for name, value, its in (
            ("turn", shape.direction_travel, length),
            ("slack", shape.slack, length),
            ("softness", shape.softness, "1"),
            ("memory", shape.memory_s, "s"),
        ):
            if value and name in self.text:
                found[name] = {"value": _rounded(value), "unit": its}
        return found

    def entry(self, is_linear: bool) -> dict[str, object]:
        """As it stands in `effects:` of a model file."""
        return {
            "kind": LawKind.FORMULA.value,
            "axis": self.shape.axis,
            "acts_on": self.shape.acts_on.value,
            "form": self.text,
            "numbers": self.numbers(is_linear),
            "source": SOURCE,
        }

    def at(self, *points: Floats) -> tuple[Floats, ...]:
        """What it answers at values of its variables, (n,) each, forward and then backward where that differs."""
        terms, inner = self.written.terms, self.written.inner
        parts = [t.columns(points, at, self.shape.by_direction) for t, at in zip(terms, inner, strict=True)]
        found = np.hstack(parts) @ self.scales
        return tuple(np.split(found, 2)) if self.shape.by_direction else (found,)


def phrase_of(one: Written) -> str:
    """What a formula looks like, in words."""
    said = [term.form.phrase for term in one.terms if term.form not in (LEVEL, SLOPE)]
    return " and ".join(sorted(said))


def formula_for(saying: Saying) -> Formula | None:
    """The shortest, by what stretches say that had no part in its numbers; None where none is worth its numbers."""
    found = _written(saying)
    if not found:
        return None
    unit = _noise(saying, min(one.leaves for one in found))
    ordered = sorted(found, key=lambda one: one.nats(saying, unit))
    for k, best in enumerate(ordered):
        if best.nats(saying, unit) >= 0.5 * saying.without_a_law() / unit:
            return None
        low, high = _interval(saying, best)
        if max(float(np.max(np.abs(ends))) for ends in (low, high)) >= LARGEST_NUMBER:
            # only the far tail of the form lies where the law was seen: no number of it is known
            continue
        near = [one for one in ordered[k + 1 :] if 0.5 * (one.leaves - best.leaves) / unit < _ALIKE]
        phrases = dict.fromkeys(phrase_of(one) for one in near)
        alike = tuple(phrase for phrase in phrases if phrase != phrase_of(best))
        return Formula(saying.shape, best, scales_of(saying, best).values, low, high, alike)
    return None


def _written(saying: Saying) -> list[Written]:
    """Formulas of one term and of two, foretold."""
    plain = beside(saying.shape)
    scans = [scanned(saying, term, None, parts) for term in terms_of(saying.shape) for parts in plain]
    ones = _close(saying, scans)
    unit = _noise(saying, min((one.leaves for one in ones), default=np.inf))
    if len(saying.points) == 2:
        return ones
    first = sorted(ones, key=lambda one: one.nats(saying, unit))[:_TWO]
    twos = [scanned(saying, term, one, ()) for one in first for term in terms_of(saying.shape)]
    return [*ones, *_close(saying, [one for one in twos if one.numbers <= _MOST_NUMBERS])]


def _close(saying: Saying, scans: list[Written]) -> list[Written]:
    """The best of them with their numbers polished, and then foretold."""
    best = sorted((one for one in scans if np.isfinite(one.takes)), key=lambda one: -one.takes)[:_CLOSELY]
    better = sorted((polished(saying, one) for one in best), key=lambda one: -one.takes)[:_FORETOLD]
    return [foretold(saying, one) for one in better]


def _noise(saying: Saying, leaves: float) -> float:
    """Squares a weighed row that are noise to the best of them: never below a floor."""
    channels = saying.straight.left.shape[1]
    return max(1.0, leaves / float(np.sum(saying.rows)) - (channels - 1))


def _interval(saying: Saying, one: Written) -> tuple[Floats, Floats]:
    """Ends of each number's interval: other draws of the stretches."""
    rng = np.random.default_rng(11)
    drawn = [_values(one, scales_of(saying, one).values)]
    for _ in range(_DRAWS):
        times = np.bincount(rng.integers(0, FOLDS, FOLDS), minlength=FOLDS).astype(float)
        there = polished(saying, one, times, again=True)
        drawn.append(_values(there, scales_of(saying, there, times).values))
    low, high = np.quantile(np.array(drawn), INTERVAL, axis=0)
    return np.minimum(low, drawn[0]), np.maximum(high, drawn[0])


def _values(one: Written, scales: Floats) -> Floats:
    """All numbers in the order of `_named`: of each term its scales, then its inner ones."""
    found: list[float] = []
    for term, inner in zip(one.terms, one.inner, strict=True):
        mine, scales = scales[: term.form.scales], scales[term.form.scales :]
        found += [*mine, *inner]
    return np.array(found)


def _named(one: Written) -> list[tuple[str, FormNumber]]:
    return [
        (names[number.name], number)
        for term, names in zip(one.terms, renamed(one.terms), strict=True)
        for number in term.form.numbers
    ]


def _over(unit: str, by: str, times: int) -> str:
    """A unit over a power of another."""
    one, other = dimension_of(unit, "a form"), dimension_of(by, "a form")
    a, b, c, d, e = (x - times * y for x, y in zip(one, other, strict=True))
    return unit_text((a, b, c, d, e))


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


__all__ = ["Formula", "formula_for", "phrase_of"]
