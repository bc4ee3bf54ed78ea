"""What cannot be in a log: rows of one column, why, and what a person does about it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: share of the rows that a repair may make up
MOST_REPAIRED = 0.02
#: rows to either side whose median is what a row is held against
AROUND = 5
MEDIAN_TO_SIGMA = 1.4826


class ColumnFault(Enum):
    """What kind of impossible it is; only a spike can be made up from its neighbours."""

    SPIKE = "spike"
    JUMP = "jump"
    STILL = "still"
    UNSIGNED = "unsigned"
    ZERO = "zero"


@dataclass(frozen=True)
class Impossible:
    """Rows of one column that cannot be; of a jump the row from which on everything lies elsewhere."""

    column: str
    rows: tuple[int, ...]
    what: str
    fault: ColumnFault = ColumnFault.SPIKE

    @property
    def can_be_made_up(self) -> bool:
        """Whether a repair may fill these rows."""
        return self.fault is ColumnFault.SPIKE


def median_around(values: Floats, around: int = AROUND) -> Floats:
    """Running median of so many rows to either side of each, (n,)."""
    from scipy.ndimage import median_filter

    return np.asarray(median_filter(values, 2 * around + 1, mode="mirror"))


def scatter_of(values: Floats) -> float:
    """Standard deviation about zero from the median size, which a few rows that are off do not move."""
    return MEDIAN_TO_SIGMA * float(np.median(np.abs(values)))
