"""A histogram of durations with a fixed relative resolution: constant memory, constant time, no arrays per tick."""

from __future__ import annotations

from dataclasses import dataclass, field

#: bins per doubling of the value: neighbouring bounds differ by at most 1/16, so a quantile is good to 6 %
_SUB_BITS = 4
_SUB = 1 << _SUB_BITS
_BINS = _SUB * (40 - _SUB_BITS + 1)


def _bin_of(value: int) -> int:
    shift = value.bit_length() - _SUB_BITS - 1
    return value if shift < 0 else min(_SUB * shift + (value >> shift), _BINS - 1)


def upper_bound_ns(index: int) -> int:
    """Largest value, in nanoseconds, that falls into bin `index`."""
    if index < 2 * _SUB:
        return index
    shift = index // _SUB - 1
    return ((index - _SUB * shift + 1) << shift) - 1


@dataclass(slots=True)
class Histogram:
    """Counts of durations in nanoseconds; values from 0 to about 18 minutes, bins 6 % wide."""

    counts: list[int] = field(default_factory=lambda: [0] * _BINS)
    count: int = 0
    total_ns: int = 0
    largest_ns: int = 0

    def add(self, value_ns: int) -> None:
        """Count one value; a negative one (a clock read between two others) counts as zero."""
        value = value_ns if value_ns > 0 else 0
        self.counts[_bin_of(value)] += 1
        self.count += 1
        self.total_ns += value
        if value > self.largest_ns:
            self.largest_ns = value

    def merge(self, other: Histogram) -> None:
        """Take in all that another one counted."""
        self.counts = [mine + theirs for mine, theirs in zip(self.counts, other.counts, strict=True)]
        self.count += other.count
        self.total_ns += other.total_ns
        self.largest_ns = max(self.largest_ns, other.largest_ns)

    def quantile_ns(self, share: float) -> int:
        """Upper bound of the bin in which the `share`-quantile lies (never above the largest value); 0 when empty."""
        wanted, seen = share * self.count, 0
        for index, count in enumerate(self.counts):
            seen += count
            if count and seen >= wanted:
                return min(upper_bound_ns(index), self.largest_ns)
        return 0

    def cumulative(self, bounds_ns: tuple[int, ...]) -> list[int]:
        """For each bound: how many values lie at or below it, to the resolution of a bin."""
        answer, index, seen = [], 0, 0
        for bound in bounds_ns:
            while index < _BINS and upper_bound_ns(index) <= bound:
                seen += self.counts[index]
                index += 1
            answer.append(seen)
        return answer

    def summary_us(self) -> dict[str, float]:
        """p50, p99, p99.9, largest and mean in microseconds."""
        mean = self.total_ns / self.count if self.count else 0.0
        return {
            "p50": self.quantile_ns(0.50) / 1e3,
            "p99": self.quantile_ns(0.99) / 1e3,
            "p999": self.quantile_ns(0.999) / 1e3,
            "max": self.largest_ns / 1e3,
            "mean": round(mean / 1e3, 3),
        }
