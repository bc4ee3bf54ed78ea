"""Time in whole nanoseconds behind one injected clock: wall time for a real antenna, lockstep for the virtual one."""

from __future__ import annotations

import time
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Protocol

NS_PER_S = 1_000_000_000


@dataclass(frozen=True, slots=True, order=True)
class Duration:
    """A length of time in whole nanoseconds."""

    ns: int

    @classmethod
    def of_seconds(cls, seconds: float) -> Duration:
        """Nearest whole number of nanoseconds to `seconds`."""
        return cls(round(seconds * NS_PER_S))

    @property
    def seconds(self) -> float:
        """The same length in seconds, for people and files only: arithmetic stays in nanoseconds."""
        return self.ns / NS_PER_S

    def __add__(self, other: Duration) -> Duration:
        return Duration(self.ns + other.ns)

    def __sub__(self, other: Duration) -> Duration:
        return Duration(self.ns - other.ns)

    def __mul__(self, times: int) -> Duration:
        return Duration(self.ns * times)

    def __floordiv__(self, other: Duration) -> int:
        return self.ns // other.ns


@dataclass(frozen=True, slots=True, order=True)
class Instant:
    """A point on one clock's line, in nanoseconds since that clock's own zero; instants of two clocks do not
    compare.
    """

    ns: int

    def __add__(self, other: Duration) -> Instant:
        return Instant(self.ns + other.ns)

    def since(self, earlier: Instant) -> Duration:
        """Time that passed from `earlier` to this instant."""
        return Duration(self.ns - earlier.ns)


class Clock(Protocol):
    """What the tick engine, timeouts and backoffs run on; nothing else in the daemon asks for the time."""

    def now(self) -> Instant:
        """The present instant; never goes back."""

    def now_ns(self) -> int:
        """The same as a bare number, for the tick path, where making objects counts."""

    def wait_until(self, deadline: Instant) -> None:
        """Return at or after `deadline`; at once when it has passed."""


class MonotonicClock:
    """CLOCK_MONOTONIC: keeps its pace when somebody sets the date. The last `spin` before a deadline is waited awake.

    Sleeping ends with the kernel's wake-up path (tens of microseconds on a quiet machine); spinning through it costs
    `spin / period` of a core and takes that path out of the latency.
    """

    def __init__(self, spin: Duration = Duration(0)) -> None:
        self._spin_ns = spin.ns

    def now(self) -> Instant:
        """The present instant of CLOCK_MONOTONIC, comparable between processes of one machine."""
        return Instant(time.monotonic_ns())

    def now_ns(self) -> int:
        """The present instant in nanoseconds."""
        return time.monotonic_ns()

    def wait_until(self, deadline: Instant) -> None:
        """Sleep to `deadline` less the spin, then spin; signals are handled during the sleep and do not shorten it."""
        end = deadline.ns
        left = end - self._spin_ns - time.monotonic_ns()
        if left > 0:
            time.sleep(left / NS_PER_S)
        while time.monotonic_ns() < end:
            pass


class LockstepClock:
    """A clock that stands still until somebody waits: each wait ends at once and moves it to the deadline."""

    def __init__(self, start: Instant = Instant(0)) -> None:
        self._now = start

    def now(self) -> Instant:
        """The instant of the last wait's deadline."""
        return self._now

    def now_ns(self) -> int:
        """The same in nanoseconds."""
        return self._now.ns

    def wait_until(self, deadline: Instant) -> None:
        """Move to `deadline`; an earlier one leaves the clock where it is."""
        self._now = max(self._now, deadline)


def wall_clock_utc() -> str:
    """Time of day for people, ISO 8601 to the millisecond; nothing computes with it."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")
