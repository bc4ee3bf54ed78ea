"""Keeps a link open: a port that is missing or gone is tried again, later and later, and never raises into the tick."""

from __future__ import annotations

from collections.abc import Callable

from firmware_protocol.errors import LinkError
from firmware_protocol.links import Link, LinkBasis, LinkState
from gimbal_hil.loop.timing import Clock, Duration, Instant

FIRST_WAIT, LONGEST_WAIT = Duration(100_000_000), Duration(2_000_000_000)
#: a link that lasted this long was a good one: the next try after its loss comes soon
GOOD_AFTER = Duration(1_000_000_000)
#: an antenna sends with every tick: after so much silence nothing is written any more, after so much the port is given
#: back and opened anew
QUIET_AFTER, CLOSED_AFTER = Duration(500_000_000), Duration(2_000_000_000)


class LinkKeeper:
    """A link that may be absent. `tell(open, text)` is called at every change, `charge(ns)` for time that link calls
    took.

    Nothing is written to a port on which no whole frame was heard since it was opened, or for some time: behind its
    name may stand another program than the antenna. Opening takes as long as the port takes; meanwhile no tick runs,
    and none would have an antenna to command.
    """

    def __init__(
        self,
        clock: Clock,
        open_link: Callable[[], Link],
        tell: Callable[[bool, str], None],
        charge: Callable[[int], None] = lambda ns: None,
    ) -> None:
        self._clock = clock
        self._open_link = open_link
        self._tell = tell
        self._charge = charge
        self._heard: Instant | None = None
        self._link: Link | None = None
        self._was_open = False
        self._opened: Instant = clock.now()
        self._next_try: Instant = clock.now()
        self._wait = FIRST_WAIT
        self._last_problem = ""
        self._last_loss = ""
        self.losses = 0

    @property
    def is_open(self) -> bool:
        """Whether frames can pass now."""
        return self._link is not None and self._link.state is LinkState.OPEN

    @property
    def complaint(self) -> str:
        """What the drives at the other end say is wrong with them; empty where they say nothing."""
        return self._link.complaint if isinstance(self._link, LinkBasis) else ""

    def receive(self) -> bytes:
        """Frames that have come; none while there is no link."""
        link = self._link
        if link is None or link.state is not LinkState.OPEN:
            if not self._come_back():
                return b""
            link = self._link
            assert link is not None
        before = self._clock.now_ns()
        block = link.receive()
        self._charge(self._clock.now_ns() - before)
        if link.speaks_first:
            self._judge_silence(link, bool(block))
        return block

    def send(self, block: bytes) -> None:
        """Send a block; dropped while there is no link."""
        link = self._link
        if link is None or link.state is not LinkState.OPEN or (link.speaks_first and not self._is_heard()):
            return
        before = self._clock.now_ns()
        link.send(block)
        self._charge(self._clock.now_ns() - before)

    def close(self) -> None:
        """Close the link for good."""
        if self._link is not None:
            self._link.close()

    def _is_heard(self) -> bool:
        return self._heard is not None and self._clock.now().since(self._heard) < QUIET_AFTER

    def _judge_silence(self, link: Link, heard: bool) -> None:
        """Silence closes the port: a half-open one does not say that its other end has gone."""
        now = self._clock.now()
        if heard:
            self._heard = now
        elif now.since(self._heard or self._opened) >= CLOSED_AFTER and now.since(self._opened) >= CLOSED_AFTER:
            why = link.why_silent() if isinstance(link, LinkBasis) else ""
            link.close()
            self._link, self._heard = None, None
            self._last_loss = f"no whole frame for {CLOSED_AFTER.ns / 1e9:g} s" + (f": {why}" if why else "")
            self._note_loss()

    def _come_back(self) -> bool:
        """Notice a loss, and try to open when it is time; a link that listens opens by itself."""
        if self._was_open:
            self._note_loss()
        now = self._clock.now()
        if now < self._next_try:
            return False
        problem = self._try()
        self._charge(self._clock.now().since(now).ns)
        if problem is not None:
            self._postpone()
            if problem != self._last_problem:
                self._last_problem = problem
                self._tell(False, f"waiting for the link: {problem}")
            return False
        self._was_open, self._last_problem, self._opened, self._heard = True, "", self._clock.now(), None
        self._tell(True, "link open")
        return True

    def _try(self) -> str | None:
        """One try to open; the reason when it failed."""
        try:
            if self._link is None:
                self._link = self._open_link()
            elif self._link.state is LinkState.LOST:
                self._link.reopen()
            elif self._link.state is LinkState.WAITING:
                self._link.receive()
        except (LinkError, OSError) as error:
            return str(error)
        return (
            None
            if self._link.state is LinkState.OPEN
            else str(self._link.loss or f"{self._link.name}: nobody has connected")
        )

    def _note_loss(self) -> None:
        self._was_open = False
        self.losses += 1
        if self._clock.now().since(self._opened) >= GOOD_AFTER:
            self._wait = FIRST_WAIT
        self._postpone()
        self._last_problem = str(self._link.loss) if self._link else self._last_loss
        self._tell(False, f"link lost: {self._last_problem}")

    def _postpone(self) -> None:
        """Not before a growing while; counted from now, so that a slow open does not follow on itself."""
        self._next_try = self._clock.now() + self._wait
        self._wait = min(self._wait * 2, LONGEST_WAIT)
