"""What could stand in the place of a cause: found, compared block by block, and put there where it explains clearly more."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from gimbal_hil.discrepancy.hypothesis import values_of
from gimbal_hil.discrepancy.search import Round, Scored, Search
from gimbal_hil.discrepancy.smoothing import block_means
from gimbal_hil.discrepancy.valleys import polished
from sim_backend.effects import CATALOGUE

#: standard errors of the blockwise difference beyond which two explanations are told apart
_TOLD_APART = 3.0
#: a rival that leaves this many squared floors a row more, relative to the best, is no rival
_CLOSE = 0.03
#: and one that leaves no more than this share more is never told apart, however sure the blocks are: no twin is that exact
_SAME = 0.003
#: one that leaves this share less, beyond the errors, is the better explanation
_LESS = 0.01
_BLOCK_S = 1.0


@dataclass(frozen=True)
class Comparison:
    """A cause against what could stand in its place."""

    rival: Scored
    #: blockwise mean of the rival's extra squares over its standard error
    told_apart: float
    #: the same extra squares as a share of what the cause leaves
    extra: float

    @property
    def close(self) -> bool:
        """Whether it could stand there: no worse by blocks, or by so little that the twin's own inexactness would do it."""
        return self.extra < _SAME or (self.told_apart < _TOLD_APART and self.extra < _CLOSE)

    @property
    def better(self) -> bool:
        """Whether the rival explains clearly more."""
        return self.extra < -_LESS and self.told_apart < -_TOLD_APART


def compare(search: Search, best: Scored, rival: Scored) -> Comparison:
    """Paired over blocks of the hold-out that may select and of the fitted data."""
    difference = np.concatenate(
        [
            np.sum(rival.fit.residual**2 - best.fit.residual**2, axis=1),
            np.sum(rival.holdout**2 - best.holdout**2, axis=1),
        ]
    )
    blocks = block_means(difference, search.twin.records[0].bands, _BLOCK_S)
    error = float(blocks.std(ddof=1) / math.sqrt(len(blocks))) if len(blocks) > 2 else math.inf
    mean = float(blocks.mean())
    level = float(np.mean(np.concatenate([np.sum(best.fit.residual**2, axis=1), np.sum(best.holdout**2, axis=1)])))
    return Comparison(rival, mean / max(error, 1e-12), mean / level)


def with_rivals(search: Search, best: Scored, null: Scored, rounds: Sequence[Round]) -> tuple[Scored, tuple[tuple[Scored, ...], ...]]:
    """An explanation and, for each of its causes, what could stand in its place, best first.

    A rival that completes the explanation and leaves clearly less takes the cause's place: the search adds what helps most before it
    is refined, and a cause with several numbers (a gap and its rotor) shows what it can do only afterwards. So does a plainer one that
    explains as much.
    """
    rivals = tuple(_rivals(search, best, index, rounds) for index in range(len(best.hypothesis.causes)))
    better = [rival for found in rivals for rival in found[:1] if compare(search, best, rival).better and search.complete(rival, null)]
    better = better or [rival for label, found in zip(best.hypothesis.labels, rivals, strict=True) for rival in found
                        if _plainer(search, best, rival.hypothesis.labels[-1], label) and compare(search, best, rival).close
                        and search.complete(rival, null)]  # fmt: skip
    if not better:
        return best, rivals
    best = polished(search, min(better, key=lambda rival: rival.cost))
    return best, tuple(_rivals(search, best, index, rounds) for index in range(len(best.hypothesis.causes)))


def _plainer(search: Search, state: Scored, one: tuple[str, str], other: tuple[str, str]) -> bool:
    """Whether one (effect, axis) says the same as another, which is a cause of the state, with fewer numbers."""
    plainer = CATALOGUE[other[0]].plainer
    if plainer is None or (plainer.name, other[1]) != one:
        return False
    found = values_of(search.twin.model, search.twin, state.hypothesis, state.hypothesis.labels.index(other))
    return plainer.holds({name: value for name, (value, _) in found.items()})


def _rivals(search: Search, best: Scored, index: int, rounds: Sequence[Round]) -> tuple[Scored, ...]:
    """What could stand in the place of one cause, refitted beside the others, best first."""
    label = best.hypothesis.labels[index]
    if len(best.hypothesis.causes) == 1:
        # the last one that began there: earlier ones were screened under other floors
        for one in reversed(rounds):
            if not one.before.hypothesis.causes and one.before.hypothesis.floating == best.hypothesis.floating:
                return _ranked(best, (search.again(s) for s in one.tried if s.hypothesis.labels[-1] != label))
    without = search.refitted(best.hypothesis.minus(index))
    tried = search.one_round(without, least=5)
    return _ranked(best, (s for s in tried.tried if s.hypothesis.labels[-1] != label))


def _ranked(best: Scored, found: Iterable[Scored]) -> tuple[Scored, ...]:
    """Best first, without those that stand only because a known number does the cause's work far beyond what a rig is off by."""
    return tuple(sorted((s for s in found if s.hypothesis.far.keys() <= best.hypothesis.far.keys()), key=lambda s: s.cost))
