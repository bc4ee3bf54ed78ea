"""Thresholds of naming a cause that trade false names against misses (docs/reference/discrepancy.md)."""

from __future__ import annotations

from dataclasses import dataclass

#: noise floors up to which a model counts as explaining the data (docs/reference/verdict.md)
LEAST_GAP = 1.5


@dataclass(frozen=True)
class Policy:
    """What a cause must show before it is told, and how far is looked."""

    #: standard errors, over blocks of data, by which a cause must pay to be added; what is told must be surer than that
    sure: float = 2.0
    #: share of what is left without it, on the channel where it shows most, that a cause must take
    least_share: float = 0.03
    #: and squared noise floors a row: less is within what a floor itself is known to, and tells no two explanations
    #: apart either
    least_squares: float = 0.12
    #: what its own scrambled response (the negative control) may take of what a cause takes
    control: float = 0.5
    #: noise floors below which a gap is none
    least_gap: float = LEAST_GAP
    #: and those up to which a gap is none that the hold-out does not repeat, or that nothing predicts
    not_repeated: float = 2.0
    #: share of the remainder, beyond its control, that may still be predicted from the variables that a named cause
    #: acts through
    exhausted: float = 0.2
    #: by how much the strength of a cause differs from stretch to stretch of the logs, as a share of it, where it is as
    #: likely something else
    uneven: float = 0.3
    #: what tells two explanations apart, beyond their standard error, since no twin is more exact: a share of the
    #: squares that are left, and this share of the rms that a cause takes
    same: float = 0.02
    #: standard errors by which another name must beat one that is there already and would do with more numbers: a
    #: further order of a ripple, or the plainer form of the same cause; and by which a law must pay
    anew: float = 3.0
    #: probability of its class from which a cause is called named, and the share of that which must be its own
    named: float = 0.95
    alone: float = 0.95


#: share of what there is from which on it is nearly all of it
NEARLY_ALL = 0.85
#: ends of an interval of 90 %
INTERVAL = (0.05, 0.95)
#: length of the blocks by which what is told of a gap is drawn again, s, and how often
BLOCK_S, DRAWS = 1.0, 300
#: causes of one verdict, the entries of one ripple counted once; entries of one ripple
MOST_CAUSES, MOST_ENTRIES = 5, 6
