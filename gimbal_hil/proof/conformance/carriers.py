"""What carries a tester's frames to an antenna and back: in step with one in this process, or in real time over a
link.
"""

from __future__ import annotations

import time
from typing import Protocol

from firmware_protocol.links import Link, LinkState
from firmware_protocol.lockstep import Ticking

#: the tester came later than this many periods: what it then finds may be its own doing
_STALL_PERIODS = 5
#: how long the first frame of an antenna on a link is waited for
_FIRST_FRAME_S = 5.0


class Carrier(Protocol):
    """Takes a block to the antenna, lets one tick pass, and answers what came."""

    #: what a person calls it
    name: str
    #: whether the antenna's time is the tester's
    in_step: bool
    rate_hz: float

    @property
    def stalls(self) -> int:
        """How often the tester itself came so late that the antenna went on without it."""

    def exchange(self, block: bytes) -> bytes:
        """One tick."""

    def close(self) -> None:
        """Give the link back."""


class InStep:
    """An antenna whose time waits for the tester, in this process or in lockstep over a link."""

    in_step = True
    stalls = 0

    def __init__(self, antenna: Ticking, name: str, rate_hz: float) -> None:
        self._antenna, self.name, self.rate_hz = antenna, name, rate_hz

    def exchange(self, block: bytes) -> bytes:
        """One tick of the antenna."""
        return self._antenna.tick(block)

    def close(self) -> None:
        """The antenna stays as it is; what stands between it and the tester is given back."""
        close = getattr(self._antenna, "close", None)
        if close is not None:
            close()


class OverLink:
    """An antenna with a clock of its own: a block goes out once a period, at absolute deadlines."""

    in_step = False

    def __init__(self, link: Link, rate_hz: float) -> None:
        self.link, self.name, self.rate_hz = link, link.name, rate_hz
        self.stalls = 0
        self._period_ns = round(1e9 / rate_hz)
        self._due_ns = 0

    def exchange(self, block: bytes) -> bytes:
        """Send, and answer what came within the period that follows."""
        now = time.monotonic_ns()
        if now - self._due_ns > _STALL_PERIODS * self._period_ns:
            # the first exchange after a pause begins a phase of its own; every other one is late
            self.stalls += self._due_ns > 0
            self._due_ns = now
        if self.link.state is LinkState.LOST:
            self.link.reopen()
        if block:
            self.link.send(block)
        self._due_ns += self._period_ns
        received = []
        while (left := self._due_ns - time.monotonic_ns()) > 0:
            if self.link.wait(left):
                received.append(self.link.receive())
            elif (left := self._due_ns - time.monotonic_ns()) > 0:
                time.sleep(left * 1e-9)
        received.append(self.link.receive())
        return b"".join(received)

    def heard(self) -> bool:
        """Whether a frame comes within the first seconds; what came is thrown away."""
        end = time.monotonic() + _FIRST_FRAME_S
        while time.monotonic() < end:
            self.link.wait(50_000_000)
            if self.link.receive():
                return True
        return False

    def close(self) -> None:
        """Give the link back."""
        self.link.close()
