"""Means of correlated rows: how far apart rows must lie to count twice, and the standard error of a difference by
blocks.

Rows of a residual are correlated, most of all where a model is incomplete. A mean over them is known as well as if
there were one row per decorrelation time; blocks of several of those are nearly independent, whatever happens inside
them (Kuensch, The jackknife and the bootstrap for general stationary observations, Ann. Statist. 17, 1989).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: decorrelation times that a block holds
_TIMES_A_BLOCK = 5
#: there are at least so many blocks
_FEWEST_BLOCKS = 12
#: a block in which two explanations differ by less than this share of what they differ by on average says nothing
_SPEAKS = 0.1


@dataclass(frozen=True)
class Paired:
    """What one explanation takes from another: mean square a row, and how surely block by block."""

    #: mean over all rows of squares before minus squares after
    mean: float
    #: mean over blocks of (before - after) / (before + after), with its standard error; blocks that both explain alike
    #: are left out
    share: float
    standard_error: float
    blocks: int

    @property
    def sure(self) -> float:
        """The share in standard errors, as a normal deviate: few blocks count for less (Student's t with blocks - 1
        degrees).
        """
        from scipy.stats import norm, t

        if self.blocks < 2:
            return 0.0
        ratio = self.share / max(self.standard_error, 1e-12)
        # beyond eight standard errors tails are no longer believed
        tail = max(float(t.logsf(abs(ratio), self.blocks - 1)), -35.0)
        return float(np.sign(ratio) * min(8.0, float(norm.isf(np.exp(tail)))))


def decorrelation_rows(rows: Floats) -> float:
    """Integrated autocorrelation time of a series (n,), in rows: 1 for white noise (initial positive sequence, Geyer
    1992).
    """
    from scipy.fft import irfft, next_fast_len, rfft

    centred = rows - rows.mean()
    n = len(centred)
    power = float(centred @ centred)
    if n < 4 or power <= 0.0:
        return 1.0
    size = next_fast_len(2 * n)
    correlation = irfft(np.abs(rfft(centred, size)) ** 2, size)[: n // 2] / power
    pairs = correlation[: len(correlation) // 2 * 2].reshape(-1, 2).sum(axis=1)
    negative = np.flatnonzero(pairs <= 0.0)
    last = int(negative[0]) if len(negative) else len(pairs)
    return float(np.clip(2.0 * pairs[:last].sum() - 1.0, 1.0, n / _FEWEST_BLOCKS))


def block_length(parts: Sequence[Floats]) -> int:
    """Rows of a block for series of one kind: several decorrelation times, and short enough to leave some blocks."""
    total = sum(len(part) for part in parts)
    times = max((decorrelation_rows(part) for part in parts if len(part) > 3), default=1.0)
    return int(max(1, min(_TIMES_A_BLOCK * times, total / _FEWEST_BLOCKS)))


def block_sums(part: Floats, length: int) -> Floats:
    """Sums over blocks of `length` rows of (n, ...); what does not fill the last block is left out."""
    n = len(part) // length * length
    return np.asarray(part[:n].reshape(-1, length, *part.shape[1:]).sum(axis=1))


def paired(before: Sequence[Floats], after: Sequence[Floats]) -> Paired:
    """Compare what two explanations leave, residuals (rows, channels) log by log, by blocks that stay inside a log.

    Each block counts alike, however much there is to explain in it; one in which the two hardly differ says nothing.
    """
    squares = [np.sum(part**2, axis=1) for part in before]
    length = block_length(squares)
    b = np.concatenate([block_sums(part, length) for part in squares])
    a = np.concatenate([block_sums(np.sum(part**2, axis=1), length) for part in after])
    moved = [block_sums(np.sum((x - y) ** 2, axis=1), length) for x, y in zip(before, after, strict=True)]
    apart = np.concatenate(moved)
    mean = float(
        sum(s.sum() - np.sum(part**2) for s, part in zip(squares, after, strict=True)) / sum(len(s) for s in squares)
    )
    speaks = apart > _SPEAKS * apart.mean()
    g = (b[speaks] - a[speaks]) / np.maximum(b[speaks] + a[speaks], 1e-300)
    if len(g) < 2:
        return Paired(mean, float(g.mean()) if len(g) else 0.0, np.inf, len(g))
    return Paired(mean, float(g.mean()), float(g.std(ddof=1) / np.sqrt(len(g))), len(g))
