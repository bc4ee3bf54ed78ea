"""Which rows of a file make a signals table: those whose time goes on, at a constant rate or without long gaps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals.resampling import GAP_PERIODS, parted_rows
from gimbal_hil.data.signals.table import JITTER_LIMIT, TIME
from gimbal_hil.data.tables import RawColumns

FEWEST_ROWS = 10


@dataclass(frozen=True)
class Repair:
    """What may be done to a log that is no signals table as it stands.

    `drop_invalid` leaves out rows that hold no number or stand still or back in time, and keeps the longest stretch of
    constant rate. `resample` puts the rows on a grid of the median period, or of `rate_hz`, which asks for a grid by
    itself. With both, invalid rows go first and the gaps are filled.
    """

    resample: bool = False
    drop_invalid: bool = False
    rate_hz: float | None = None

    @property
    def to_grid(self) -> bool:
        """Whether rows are put on a grid."""
        return self.resample or self.rate_hz is not None

    @property
    def period_s(self) -> float | None:
        """Period of that grid; None for the data's own. Raises BadInputError when the rate is none."""
        if self.rate_hz is None:
            return None
        if not 0.0 < self.rate_hz < float("inf"):
            raise BadInputError(f"--rate {self.rate_hz:g}", "is no rate", "rows a second, above zero")
        return 1.0 / self.rate_hz


class RepairableError(BadInputError):
    """Refused as it stands; `trials` are repairs that may do."""

    def __init__(self, where: str, problem: str, expected: str, trials: tuple[Repair, ...] | None = None) -> None:
        super().__init__(where, problem, expected)
        self.trials = (Repair(resample=True), Repair(drop_invalid=True)) if trials is None else trials


def forward_rows(raw: RawColumns, rows: NDArray[np.int64], repair: bool, notes: list[str]) -> NDArray[np.int64]:
    """Rows whose time is later than all before; where the clock starts again, those of its longest part."""
    require_rows(raw, len(rows))
    time_s = raw.values[TIME][rows]
    latest = np.maximum.accumulate(time_s)
    forward = np.concatenate(([True], time_s[1:] > latest[:-1]))
    if forward.all():
        return rows
    at = int(np.argmin(forward))
    problem = (
        "is the same as in the row before" if time_s[at] == time_s[at - 1] else "is not later than in the rows before"
    )
    where = raw.where(int(rows[at]), TIME)
    count = np.count_nonzero(~forward)
    if not repair:
        raise RepairableError(where, f"{problem} ({time_s[at]:.9g} s)", f"increasing times ({count} rows are not)")
    kept, cuts = _without_strays(time_s)
    if len(kept) < len(rows):
        notes.append(f"{len(rows) - len(kept)} rows were left out because their time {problem}, the first at {where}")
    if not len(cuts):
        return rows[kept]
    edges = np.concatenate(([0], cuts, [len(kept)]))
    longest = int(np.argmax(np.diff(edges)))
    part = rows[kept[edges[longest] : edges[longest + 1]]]
    notes.append(
        f"the clock starts again ({len(cuts)} in all), first at {raw.where(int(rows[kept[cuts[0]]]), TIME)}: of its "
        f"parts the longest was kept, {len(part)} of {len(rows)} rows from {raw.where(int(part[0]), TIME)} on"
    )
    return part


def _without_strays(time_s: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Places without repeated times and without single ones that are out of order; where among them the clock falls
    back and goes on from there.
    """
    kept = np.flatnonzero(np.concatenate(([True], np.diff(time_s) != 0.0)))
    at = time_s[kept]
    stray = np.zeros(len(kept), dtype=np.bool_)
    for k in np.flatnonzero(np.diff(at) < 0.0) + 1:
        if k + 1 == len(at) or at[k + 1] > at[k - 1]:
            stray[k] = True
        elif k == 1 or at[k] > at[k - 2]:
            stray[k - 1] = True
    kept = kept[~stray]
    return kept, np.flatnonzero(np.diff(time_s[kept]) <= 0.0) + 1


def unparted_rows(raw: RawColumns, rows: NDArray[np.int64], notes: list[str]) -> NDArray[np.int64]:
    """The longest part of rows without a gap that is too long to be bridged."""
    time_s = raw.values[TIME][rows]
    edges = np.concatenate(([0], parted_rows(time_s), [len(rows)]))
    if len(edges) == 2:
        return rows
    longest = int(np.argmax(np.diff(edges)))
    part = rows[edges[longest] : edges[longest + 1]]
    at = int(edges[1])
    notes.append(
        f"gaps that are too long to be bridged: {len(edges) - 2}, the first one of {time_s[at] - time_s[at - 1]:.4g} s "
        f"before {raw.where(int(rows[at]), TIME)}; the longest part without one was kept, {len(part)} of {len(rows)} "
        "rows"
    )
    require_rows(raw, len(part))
    return part


def steady_rows(raw: RawColumns, rows: NDArray[np.int64], cut: bool, notes: list[str]) -> NDArray[np.int64]:
    """Rows of constant rate: all of them, or the longest stretch of them when `cut`."""
    require_rows(raw, len(rows))
    time_s = raw.values[TIME][rows]
    steps = np.diff(time_s)
    period = float(np.median(steps))
    unsteady = np.abs(steps - period) > JITTER_LIMIT * period
    if not unsteady.any():
        return rows
    at = int(np.argmax(unsteady))
    problem = f"comes {steps[at] / period:.4g} periods of {period:.6g} s after the row before"
    word = "a gap" if steps[at] > GAP_PERIODS * period else "jitter over 5 % of the period"
    gaps = np.count_nonzero(steps > GAP_PERIODS * period)
    summary = f"{gaps} gaps and {np.count_nonzero(unsteady) - gaps} jittering steps"
    where = raw.where(int(rows[at + 1]), TIME)
    if not cut:
        raise RepairableError(where, f"{problem}: {word}", f"a constant rate ({summary} in the file)")
    edges = np.concatenate(([0], np.flatnonzero(unsteady) + 1, [len(rows)]))
    longest = int(np.argmax(np.diff(edges)))
    start, stop = int(edges[longest]), int(edges[longest + 1])
    if stop - start < FEWEST_ROWS:
        raise RepairableError(
            where,
            f"{problem}: {word}, and no stretch of constant rate has {FEWEST_ROWS} rows",
            "a constant rate",
            (Repair(resample=True),),
        )
    notes.append(
        f"{summary}: kept the longest stretch of constant rate, {stop - start} of {len(raw.values[TIME])} rows"
    )
    return rows[start:stop]


def require_rows(raw: RawColumns, count: int) -> None:
    """Raise BadInputError for fewer rows than a log has."""
    if count < FEWEST_ROWS:
        raise BadInputError(str(raw.path), f"has {count} usable rows", f"at least {FEWEST_ROWS}")
