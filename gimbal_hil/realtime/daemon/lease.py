"""A motion belongs to the client that asked for it, as long as that client says so: the lease, counted in ticks.

A client that is slow renews from a thread of its own and is not taken for a dead one; one that was killed has its
connection closed by the system, which ends the lease at once; one that stands still says nothing until its ticks are
used up.
"""

from __future__ import annotations


class Lease:
    """The lease of one motion, which is known by the number of its request.

    Only ticks that ran use it up: while the whole machine stood still its client stood still too.
    """

    def __init__(self, motion: int, ticks: int, period_ns: int) -> None:
        self.motion, self._ticks, self._left = motion, ticks, ticks
        self._said = f"said nothing for {ticks * period_ns / 1e9:g} s"
        #: why the motion's client counts as gone, empty while it does not
        self.ended = ""

    def renew(self) -> None:
        """The client is there."""
        self._left = self._ticks

    def client_gone(self) -> None:
        """Its connection has closed."""
        self.ended = "closed its connection"

    def pass_tick(self) -> None:
        """One more tick runs."""
        self._left -= 1
        if self._left <= 0 and not self.ended:
            self.ended = self._said
