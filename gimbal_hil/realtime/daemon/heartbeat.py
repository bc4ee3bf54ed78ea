"""Whether the service process still works."""

from __future__ import annotations

from collections.abc import Callable

from gimbal_hil.loop.timing import Duration, Instant


class Heartbeat:
    """Whether the service process still works: it takes what every tick leaves for it, so its progress never stands
    still for long. Time counts from the first look on: before ticks run there is nothing to take.
    """

    def __init__(self, progress: Callable[[], int], timeout: Duration) -> None:
        self._progress, self._timeout = progress, timeout
        self._last: int | None = None
        self._since: Instant | None = None

    def missed(self, now: Instant) -> bool:
        """Whether there was no progress for the whole of the timeout."""
        progress = self._progress()
        if self._since is None or progress != self._last:
            self._last, self._since = progress, now
        return now.since(self._since) >= self._timeout

    def __str__(self) -> str:
        return f"the service process has not answered for {self._timeout.ns / 1e9:g} s"
