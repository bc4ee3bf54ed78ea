"""What every link does, whatever carries the frames: blocks out, blocks in, never a wait and never an exception in the
tick.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from firmware_protocol.errors import LinkError
from firmware_protocol.schema import RECORD_SIZE

#: bytes of whole records that a link hands out or buffers at most in one call
BLOCK_LIMIT = 4096 * RECORD_SIZE


class LinkState(Enum):
    """Whether frames can pass."""

    WAITING = "waiting"  # listening, nobody has connected
    OPEN = "open"
    LOST = "lost"
    CLOSED = "closed"


@dataclass(frozen=True)
class LinkLost:
    """The event of a link whose peer, port or bus went away."""

    link: str
    reason: str

    def __str__(self) -> str:
        return f"{self.link}: {self.reason}"


@dataclass
class LinkStatistics:
    """Counts since the link was made; reopening does not clear them."""

    frames_sent: int = 0
    frames_received: int = 0
    frames_dropped: int = 0  # could not be sent: no peer, or its buffer is full
    malformed: int = 0  # packets or frames that were not ours or not whole
    losses: int = 0
    reopened: int = 0


class Link(Protocol):
    """A two-way carrier of blocks.

    `send` and `receive` return at once and do not raise once the link was opened: what cannot be sent is counted and
    dropped, a lost peer shows as `state` LOST with `loss` saying why, until `reopen` answers True.
    """

    @property
    def name(self) -> str:
        """What a person calls it, as in `serial /dev/ttyUSB0`."""

    @property
    def state(self) -> LinkState:
        """Whether frames can pass now."""

    @property
    def loss(self) -> LinkLost | None:
        """Why the link is not open, when it is not."""

    @property
    def statistics(self) -> LinkStatistics:
        """Counts since the link was made."""

    @property
    def speaks_first(self) -> bool:
        """Whether the antenna at its end sends without being spoken to, as every real one does with every tick."""

    def send(self, block: bytes) -> None:
        """Send whole records."""

    def receive(self) -> bytes:
        """Everything that has come since the last call, as one block; empty when nothing has."""

    def wait(self, timeout_ns: int) -> bool:
        """Sleep until something can be received, at most that long; whether something can."""

    def reopen(self) -> bool:
        """Try once to open a lost link again; whether it is open now."""

    def close(self) -> None:
        """Give the port, socket or bus back; may be called twice."""

    def fileno(self) -> int:
        """File descriptor that becomes readable with the link, or -1 where there is none."""


class LinkBasis(ABC):
    """Name, state and counts of a link, and how a lost one is opened again."""

    speaks_first = True
    #: what the other end says is wrong with it, in its maker's words; empty where it says nothing
    complaint: str = ""

    def __init__(self, name: str) -> None:
        self._name = name
        self._state = LinkState.CLOSED
        self._loss: LinkLost | None = None
        self._statistics = LinkStatistics()

    @property
    def name(self) -> str:
        return self._name

    @property
    def state(self) -> LinkState:
        return self._state

    @property
    def loss(self) -> LinkLost | None:
        return self._loss

    @property
    def statistics(self) -> LinkStatistics:
        return self._statistics

    def why_silent(self) -> str:
        """What is known of an other end that says nothing; empty where nothing is."""
        return ""

    def reopen(self) -> bool:
        """Try once to open a lost link again; whether it is open now."""
        if self._state is not LinkState.OPEN:
            try:
                self._connect()
            except LinkError as error:
                self._lost(error)
        return self._state is LinkState.OPEN

    @abstractmethod
    def _connect(self) -> None:
        """Open it and call `_opened`, or raise LinkError. A listening end may also go on waiting for its peer."""

    def _opened(self) -> None:
        if self._loss is not None:
            self._statistics.reopened += 1
        self._state, self._loss = LinkState.OPEN, None

    def _lost(self, reason: object, state: LinkState = LinkState.LOST) -> None:
        if self._state is LinkState.OPEN:
            self._statistics.losses += 1
        self._state, self._loss = state, LinkLost(self._name, str(reason))

    def _count_sent(self, block: bytes, sent: bool) -> None:
        if sent:
            self._statistics.frames_sent += len(block) // RECORD_SIZE
        else:
            self._statistics.frames_dropped += len(block) // RECORD_SIZE

    def _count_received(self, block: bytes) -> bytes:
        self._statistics.frames_received += len(block) // RECORD_SIZE
        return block
