"""What identification says about a number: value, interval, verdict, and what to do when the data cannot tell."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from enum import Enum

#: half of the interval relative to the value, up to which a parameter counts as identified, and as weakly identified
IDENTIFIED_RELATIVE_WIDTH = 0.25
WEAK_RELATIVE_WIDTH = 1.0


class Determination(Enum):
    """How far the data determine a parameter, from best to least."""

    IDENTIFIED = "identified"
    WEAKLY_IDENTIFIED = "weakly_identified"
    NOT_IDENTIFIED = "not_identified"

    @property
    def rank(self) -> int:
        """Place in that order, from zero."""
        return list(Determination).index(self)


@dataclass(frozen=True)
class Interval:
    """A 95 % interval; an open side ran into the physical bound without the data objecting."""

    low: float
    high: float
    open_low: bool = False
    open_high: bool = False

    @property
    def half_width(self) -> float:
        """How far off the value may be, to either side: the uncertainty that a model file states."""
        return 0.5 * (self.high - self.low)

    def covers(self, value: float) -> bool:
        """True when the value lies in the interval, bounds included."""
        return self.low <= value <= self.high

    def overlaps(self, other: Interval) -> bool:
        """True when some value lies in both."""
        return self.low <= other.high and other.low <= self.high

    def moved(self, by: float) -> Interval:
        """The interval made to hold itself as a whole elsewhere too, as far as its ends are no bounds."""
        low = self.low if self.open_low else self.low + min(0.0, by)
        return replace(self, low=low, high=self.high if self.open_high else self.high + max(0.0, by))

    def stretched_over(self, values: Sequence[float]) -> Interval:
        """The interval made to hold these values too."""
        return replace(self, low=min(self.low, *values), high=max(self.high, *values))


#: numbers of friction as people call them, by the keys of a model file
_SAID = {
    "breakaway": "break-away",
    "coulomb": "Coulomb friction",
    "stribeck_velocity": "Stribeck velocity",
    "viscous": "viscous friction",
    "shape": "Stribeck shape",
    "sigma0": "bristle stiffness",
    "sigma1": "bristle damping",
}


def said(name: str) -> str:
    """A number as people call it: `sigma0` is "bristle stiffness"."""
    return _SAID.get(name, name.replace("_", " "))


def number_text(value: float | None, digits: int = 5) -> str:
    """A number as for a person; a dash where there is none."""
    return "–" if value is None or not math.isfinite(value) else f"{value:.{digits}g}"


@dataclass(frozen=True)
class Estimate:
    """One parameter: the value to use, what the data alone said, and how much that is worth.

    `value` is the fitted value, or the prior when the verdict is NOT_IDENTIFIED and a prior exists; `fitted` is always
    what the data said. `experiment` names the run that would settle it, empty when nothing is open.
    """

    name: str
    value: float
    interval: Interval
    unit: str
    verdict: Determination
    fitted: float
    prior: float | None = None
    reason: str = ""
    experiment: str = ""

    @property
    def digits(self) -> int:
        """Digits at which the interval shows with two of its own, five at least."""
        width = self.interval.high - self.interval.low
        if not (math.isfinite(width) and width > 0.0 and math.isfinite(self.fitted) and self.fitted != 0.0):
            return 5
        return min(max(math.ceil(math.log10(abs(self.fitted)) - math.log10(width)) + 2, 5), 9)

    @property
    def value_text(self) -> str:
        """The value to use, as for a person."""
        return number_text(self.value, self.digits)

    @property
    def fitted_text(self) -> str:
        """What the data alone said, as for a person."""
        return number_text(self.fitted, self.digits)

    @property
    def end_texts(self) -> tuple[str, str]:
        """Both ends of the interval, as for a person; one that is open in brackets."""
        low, high = (number_text(end, self.digits) for end in (self.interval.low, self.interval.high))
        return f"({low})" if self.interval.open_low else low, f"({high})" if self.interval.open_high else high

    @property
    def fitted_ends(self) -> bool:
        """Whether the data set at least one end of the interval."""
        return not (self.interval.open_low and self.interval.open_high)

    @property
    def interval_text(self) -> str:
        """The interval as one text."""
        return " to ".join(self.end_texts)

    def as_record(self) -> dict[str, object]:
        """Plain types for `identification.json`."""
        record = asdict(self)
        interval = record.pop("interval")
        return {**record, "verdict": self.verdict.value, "low": interval["low"], "high": interval["high"],
                "open_low": interval["open_low"], "open_high": interval["open_high"]}  # fmt: skip


#: units of a linear axis for those of a rotary one
_STRAIGHT = {"N m": "N", "rad/s": "m/s", "N m s/rad": "N s/m", "N m/rad": "N/m"}


def straight(estimate: Estimate) -> Estimate:
    """The estimate in the units of a linear axis."""
    return replace(estimate, unit=_STRAIGHT.get(estimate.unit, estimate.unit))


@dataclass(frozen=True)
class DataWarning:
    """A contradiction in the data or a violated physical bound: `rule` is its short name, `text` the sentence a person
    reads.

    `concerns` names the parameters whose values it is about.
    """

    rule: str
    text: str
    axis: str = ""
    concerns: frozenset[str] = frozenset()


def judge(interval: Interval, fitted: float) -> Determination:
    """The verdict that an interval alone supports.

    Identified: closed on both sides and at most 25 % half width; weakly identified: at most one side open and at most
    100 % half width; anything else is not identified.
    """
    scale = abs(fitted)
    relative = (interval.high - interval.low) / (2.0 * scale) if scale > 0.0 else float("inf")
    open_sides = interval.open_low + interval.open_high
    if open_sides == 0 and relative <= IDENTIFIED_RELATIVE_WIDTH:
        return Determination.IDENTIFIED
    if open_sides <= 1 and relative <= WEAK_RELATIVE_WIDTH:
        return Determination.WEAKLY_IDENTIFIED
    return Determination.NOT_IDENTIFIED


def settle(
    name: str, fitted: float, interval: Interval, unit: str, prior: float | None, experiment: str, reason: str = ""
) -> Estimate:
    """An estimate whose verdict comes from its interval; a parameter that is not identified goes back to its prior and
    says so.
    """
    verdict = judge(interval, fitted)
    if verdict is Determination.IDENTIFIED:
        return Estimate(name, fitted, interval, unit, verdict, fitted, prior, reason)
    if verdict is Determination.WEAKLY_IDENTIFIED:
        why = reason or "the interval is wider than a quarter of the value or ends at a physical bound"
        return Estimate(name, fitted, interval, unit, verdict, fitted, prior, why, experiment)
    why = reason or "the data fit about as well over a range wider than the value itself"
    return Estimate(name, fitted if prior is None else prior, interval, unit, verdict, fitted, prior, why, experiment)


def withheld(name: str, unit: str, prior: float | None, reason: str, experiment: str) -> Estimate:
    """A parameter that this data was not asked about at all, because it cannot say anything: prior kept, interval
    without bounds.
    """
    value = float("nan") if prior is None else prior
    nothing = Interval(0.0, float("inf"), open_low=True, open_high=True)
    return Estimate(name, value, nothing, unit, Determination.NOT_IDENTIFIED, float("nan"), prior, reason, experiment)
