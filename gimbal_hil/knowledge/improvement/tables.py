"""What each run of an improvement is for, and which runs a search and its hold-out are made of."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from gimbal_hil.data.signals import SignalsTable

#: tables that one diagnosis searches on at most: the newest, and the first
_MOST_SEARCHED = 5


class Role(Enum):
    """What a run is for."""

    #: rich motion to search on
    SEARCH = "search"
    #: rich motion that no model has seen; once a newer one is there, it is searched on as well
    JUDGE = "judge"
    #: tells two explanations apart
    SEPARATING = "separating"
    #: shows a cause that the judge does not show: held out beside it until the next run, searched on from then on
    SHOWN = "shown"


@dataclass
class Tables:
    """Measured tables by role, each in the order in which they were measured."""

    search: list[SignalsTable] = field(default_factory=list)
    judge: list[SignalsTable] = field(default_factory=list)
    shown: list[SignalsTable] = field(default_factory=list)

    def add(self, role: Role, table: SignalsTable) -> None:
        """One more run."""
        # a run on one axis has said what it was made for: as a hold-out it would only thin out the others
        self.search += self.shown
        self.shown.clear()
        {Role.JUDGE: self.judge, Role.SHOWN: self.shown}.get(role, self.search).append(table)

    def searched(self) -> tuple[SignalsTable, ...]:
        """Tables for a search: all that are not held out, older ones left out beyond a number."""
        tables = [*self.search, *self.judge[:-1]]
        return tuple(tables if len(tables) <= _MOST_SEARCHED else [tables[0], *tables[1 - _MOST_SEARCHED :]])

    def held_out(self) -> tuple[SignalsTable, ...]:
        """Tables that a search is judged on."""
        return (self.judge[-1], *self.shown)
