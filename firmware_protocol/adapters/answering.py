"""Whether a sample that came is the answer to the last question: drives put no number on their answers.

An answer that is late by a tick is found at the next look, before that of the next question. It looks as if the first
one had been lost and this were the second: the sample would have the tick after its own, which a model takes for time
between torque and position, and a position that does not move for a tick. One look later both are told apart: after a
late answer two samples come, after a lost one a single one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

#: of the last sets, which are so many, the share before which answers were lost: a drive that leaves out more as a rule
#: is taken by its word
_SETS, _AS_A_RULE = 16, 0.25
#: sets in a row that may be refused
_MOST_REFUSED = 2


@dataclass
class Answering:
    """The looks at drives that are asked at each tick, between the answers and the next question."""

    _owed: int = 0
    _refused: int = 0
    _lost_share: float = 0.0

    def is_of_this_tick(self, samples: Sequence[int]) -> bool:
        """For one look and how many new samples it found of each drive: whether the newest ones answer the last
        question.
        """
        self._owed += 1
        came = min(samples)
        if came == 0:
            return False
        all_came = came >= self._owed
        # what is still owed after a refusal was lost, where no more than the answer to the last question came
        lost = self._refused > 0 and came == 1
        if not all_came and not lost and self._refused < _MOST_REFUSED and self._lost_share < _AS_A_RULE:
            self._owed, self._refused = self._owed - came, self._refused + 1
            return False
        self._owed, self._refused = 0, 0
        self._lost_share += ((0.0 if all_came else 1.0) - self._lost_share) / _SETS
        return True
