"""How late the torque of a log is against its positions: seconds with an interval, and what a reader does about it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gimbal_hil.knowledge.identification.estimate import DataWarning, Interval

#: what states a time that the data contradict or cannot tell
STATE_IT = "--column AXIS.torque=COLUMN@-2ms"


@dataclass(frozen=True)
class Timing:
    """The torque of a row was in force `late` seconds before its stamp says (a row's torque acts from t_k to t_k+1).

    `lag_s` is the part of it that is a first-order lag (a low-pass), zero where a shift alone does as well. `used` says
    whether the numbers were fitted with it; it is not where the interval holds zero, or where the time was `stated`.
    """

    late_s: float
    late: Interval
    lag_s: float
    period_s: float
    used: bool
    stated: bool = False
    #: it was sought up to so much either way
    sought_s: float = math.inf

    @property
    def rows(self) -> float:
        """The same in rows."""
        return self.late_s / self.period_s

    @property
    def excludes_zero(self) -> bool:
        """Whether the data say that torque and position are apart."""
        return not self.late.covers(0.0)

    def excludes(self, rows: float) -> bool:
        """Whether the data say that they are apart by more than so many rows; they do not where they allow for more
        than was sought.
        """
        if self.late.low < -self.sought_s or self.late.high > self.sought_s:
            return False
        return self.late.low > rows * self.period_s or self.late.high < -rows * self.period_s

    @property
    def text(self) -> str:
        """The sentence a person reads."""
        size = f"{1e3 * abs(self.late_s):.3g} ms ({abs(self.rows):.2g} rows)"
        low, high = (f"{1e3 * end:.3g}" for end in (self.late.low, self.late.high))
        if not self.excludes_zero:
            return f"torque and position may well be at the same time ({low} to {high} ms apart)"
        way = "late against" if self.late_s > 0.0 else "early against"
        lag = f", {1e3 * self.lag_s:.3g} ms of it a low-pass" if self.lag_s > 0.0 else ""
        return f"the torque column is {size} {way} the positions, {low} to {high} ms{lag}"

    def stated_by(self, axis: str) -> str:
        """The option that would state what was found."""
        return f"--column {self.stated_as(axis)}"

    def stated_as(self, axis: str) -> str:
        """What that option says of a torque column."""
        return f"{axis}.torque=COLUMN@{-1e3 * self.late_s:.3g}ms"

    def findings(self, axis: str) -> tuple[DataWarning, ...]:
        """What speaks against the log, if anything."""
        if not self.excludes_zero:
            return ()
        if self.stated:
            text = f"{self.text}, although their times were stated: the numbers are as stated"
            return (DataWarning("time_disagrees", text, axis),)
        stated = self.stated_by(axis)
        text = f"{self.text}: the numbers and their intervals allow for it; if it is known, state it, as {stated}"
        return (DataWarning("torque_shifted", text, axis),)

    def as_record(self) -> dict[str, object]:
        """Plain types for `identification.json`."""
        return {
            "late_s": self.late_s,
            "low_s": self.late.low,
            "high_s": self.late.high,
            "lag_s": self.lag_s,
            "rows": self.rows,
            "used": self.used,
            "stated": self.stated,
            "text": self.text,
        }
