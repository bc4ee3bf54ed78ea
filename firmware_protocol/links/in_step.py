"""The host's end of lockstep over a link: an antenna that advances by one tick on request."""

from __future__ import annotations

import time

from firmware_protocol.errors import LinkError
from firmware_protocol.links.link import Link, LinkState
from firmware_protocol.lockstep import BEGIN, EdgeParser, edge, next_edge
from firmware_protocol.schema import RECORD_SIZE

#: how long an answer is waited for, unless somebody says otherwise
PATIENCE_S = 30.0
#: a wait is looked after so often, for somebody who wants to end it
_LOOK_NS = 100_000_000
#: how long an answer is still waited for once somebody wants to end it
_HURRY_NS = 1_000_000_000
#: an antenna that does not answer the first edge but speaks has a clock of its own
_OTHER_CLOCK_NS = 2_000_000_000
_EXPECTED = "an antenna in lockstep, as gimbal-hil plant --lockstep"


class AntennaInStep:
    """An antenna at the other end of a link whose time waits for this end (`firmware_protocol.lockstep`).

    Each answer is waited for `patience_s` seconds of the wall clock, for ever with 0. Raises LinkError where the other
    end does not begin.
    """

    def __init__(self, link: Link, patience_s: float = PATIENCE_S) -> None:
        self._link, self._hurried = link, False
        self._patience_ns = round(patience_s * 1e9)
        self._parser = EdgeParser()
        self._number = BEGIN
        self.name = link.name
        self._await_peer()
        # what was meant for somebody else
        link.receive()
        self._answer(b"", BEGIN)

    def tick(self, received: bytes = b"") -> bytes:
        """Hand a block over, let the antenna go on by one tick, answer the block of that tick; LinkError where none
        comes.
        """
        self._number = next_edge(self._number)
        # a fragment would take the edge with it
        return self._answer(received[: len(received) - len(received) % RECORD_SIZE], self._number)

    def hurry(self) -> None:
        """Wait no longer than a second for an answer from now on; may be called from a signal handler."""
        self._hurried = True

    def close(self) -> None:
        """Give the link back; the antenna's time stands still."""
        self._link.close()

    def _await_peer(self) -> None:
        """A link that listens opens when its peer comes."""
        began = time.monotonic_ns()
        while self._link.state is LinkState.WAITING:
            self._link.receive()
            if self._link.state is LinkState.WAITING:
                self._require_patience(began, "nobody has connected")
                self._link.wait(_LOOK_NS)

    def _answer(self, block: bytes, number: int) -> bytes:
        link, parser = self._link, self._parser
        link.send(block + edge(number))
        # the clock is asked only where there is something to wait for
        began = 0
        while True:
            parser.feed(link.receive())
            answer = parser.before(number)
            if answer is not None:
                return answer
            if link.state is not LinkState.OPEN:
                raise LinkError(str(link.loss or f"{link.name}: closed"))
            began = began or time.monotonic_ns()
            if number != BEGIN:
                self._require_patience(began, f"no answer to tick {number}")
            elif parser.kept and time.monotonic_ns() - began > _OTHER_CLOCK_NS:
                raise LinkError(f"{link.name}: speaks without being asked; expected {_EXPECTED}")
            else:
                self._require_patience(began, "no answer in lockstep", f"; expected {_EXPECTED}")
            link.wait(_LOOK_NS)

    def _require_patience(self, began_ns: int, problem: str, hint: str = "") -> None:
        waited = time.monotonic_ns() - began_ns
        if (self._patience_ns and waited >= self._patience_ns) or (self._hurried and waited >= _HURRY_NS):
            raise LinkError(f"{self.name}: {problem} for {waited / 1e9:.0f} s{hint}")
