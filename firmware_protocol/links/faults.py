"""A link with faults in it, by seed: the same seed and the same frames give the same faults, in each direction on its
own.

Time is counted in calls of `receive`, which a loop makes once per tick. Everything that goes wrong here goes wrong with
blocks and bits, below the codec: nothing in this module knows what a frame means.
"""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

from pydantic import Field

from firmware_protocol.documents import Strict
from firmware_protocol.links.link import Link, LinkLost, LinkState, LinkStatistics
from firmware_protocol.schema import RECORD_SIZE


class DirectionFaults(Strict):
    """How often a frame (for `truncate`: a block) suffers what; probabilities from 0 to 1."""

    drop: float = Field(default=0.0, ge=0, le=1, description="the frame is lost")
    duplicate: float = Field(default=0.0, ge=0, le=1, description="it comes twice")
    reorder: float = Field(default=0.0, ge=0, le=1, description="the frame comes after the next one")
    corrupt: float = Field(default=0.0, ge=0, le=1, description="bits of it are flipped")
    corrupt_bits: int = Field(
        default=1, ge=1, le=80, description="bits flipped at random places of identifier and payload"
    )
    truncate: float = Field(default=0.0, ge=0, le=1, description="the block ends at a random byte")
    delay: float = Field(default=0.0, ge=0, le=1, description="it comes later")
    delay_ticks: int = Field(default=1, ge=1, description="by so many ticks")


class Cut(Strict):
    """Nothing passes from `start_tick` on for `ticks` ticks; `visible`: the port itself is gone meanwhile and has to be
    reopened.
    """

    start_tick: int = Field(ge=0, description="first tick of the cut")
    ticks: int = Field(ge=1, description="how long it lasts")
    visible: bool = Field(default=False, description="the port itself is gone meanwhile and has to be reopened")

    def covers(self, tick: int) -> bool:
        """Whether the line is cut at this tick."""
        return self.start_tick <= tick < self.start_tick + self.ticks


class FaultsConfig(Strict):
    """Faults of both directions of a link."""

    seed: int = Field(default=0, description="of the faults; the same seed and frames give the same faults")
    send: DirectionFaults = Field(default=DirectionFaults(), description="of frames that this end sends")
    receive: DirectionFaults = Field(default=DirectionFaults(), description="of frames that this end receives")
    cuts: tuple[Cut, ...] = Field(default=(), description="times at which nothing passes")


class FaultyDirection:
    """The frames of one direction on their way."""

    def __init__(self, faults: DirectionFaults, seed: str) -> None:
        self._faults = faults
        self._random = Random(seed)
        self._overtaken: list[bytes] = []
        self._delayed: list[tuple[int, bytes]] = []

    def pass_on(self, block: bytes, tick: int) -> bytes:
        """What arrives at this tick when this block is sent."""
        arriving = [record for due, record in self._delayed if due <= tick]
        self._delayed = [(due, record) for due, record in self._delayed if due > tick]
        for at in range(0, len(block), RECORD_SIZE):
            overtaken, self._overtaken = self._overtaken, []
            passing = list(self._suffer(block[at : at + RECORD_SIZE], tick))
            if passing:
                arriving += passing + overtaken
            else:
                self._overtaken = overtaken + self._overtaken
        arrived = b"".join(arriving)
        if block and self._random.random() < self._faults.truncate:
            arrived = arrived[: self._random.randrange(len(arrived) + 1)]
        return arrived

    def clear(self) -> None:
        """Lose what is on its way."""
        self._overtaken.clear()
        self._delayed.clear()

    def _suffer(self, record: bytes, tick: int) -> Iterator[bytes]:
        # always the same number of draws, so that one fault more or less does not change all later ones
        drop, duplicate, reorder, corrupt, delay = (self._random.random() for _ in range(5))
        flips = [self._random.randrange(8 * RECORD_SIZE) for _ in range(self._faults.corrupt_bits)]
        if drop < self._faults.drop:
            return
        if corrupt < self._faults.corrupt:
            record = _flipped(record, flips)
        copies = 2 if duplicate < self._faults.duplicate else 1
        if delay < self._faults.delay:
            self._delayed += [(tick + self._faults.delay_ticks, record)] * copies
        elif reorder < self._faults.reorder:
            self._overtaken += [record] * copies
        else:
            yield from [record] * copies


def _flipped(record: bytes, bits: list[int]) -> bytes:
    word = int.from_bytes(record, "little")
    for bit in bits:
        word ^= 1 << bit % (8 * len(record))
    return word.to_bytes(len(record), "little")


class FaultyLink:
    """A link in which frames are dropped, doubled, overtaken, changed, cut short, delayed, or stopped altogether."""

    def __init__(self, link: Link, config: FaultsConfig) -> None:
        self._link = link
        self._cuts = config.cuts
        self._outbound = FaultyDirection(config.send, f"{config.seed} send")
        self._inbound = FaultyDirection(config.receive, f"{config.seed} receive")
        self._severed: LinkLost | None = None
        self.tick = 0

    @property
    def name(self) -> str:
        """Name of the link beneath."""
        return f"{self._link.name} with faults"

    @property
    def speaks_first(self) -> bool:
        """As the link beneath."""
        return self._link.speaks_first

    @property
    def state(self) -> LinkState:
        """LOST through a visible cut, else that of the link beneath."""
        return self._link.state if self._severed is None else LinkState.LOST

    @property
    def loss(self) -> LinkLost | None:
        """The visible cut, else the loss of the link beneath."""
        return self._severed or self._link.loss

    @property
    def statistics(self) -> LinkStatistics:
        """Counts of the link beneath: frames that really went through it."""
        return self._link.statistics

    def send(self, block: bytes) -> None:
        """Send what the faults leave of a block."""
        if not self._is_cut():
            self._forward(self._outbound.pass_on(block, self.tick))

    def receive(self) -> bytes:
        """What the faults leave of what has come; one tick passes."""
        self.tick += 1
        arrived = self._link.receive()
        if self._is_cut():
            return b""
        self._forward(self._outbound.pass_on(b"", self.tick))
        return self._inbound.pass_on(arrived, self.tick)

    def wait(self, timeout_ns: int) -> bool:
        """As the link beneath."""
        return self._link.wait(timeout_ns)

    def reopen(self) -> bool:
        """Fails during a visible cut."""
        if self._severed is not None and self._present_cut() is None:
            self._severed = None
        return self._severed is None and self._link.reopen()

    def close(self) -> None:
        """Close the link beneath."""
        self._link.close()

    def fileno(self) -> int:
        """Descriptor of the link beneath."""
        return self._link.fileno()

    def _is_cut(self) -> bool:
        cut = self._present_cut()
        if cut is not None:
            self._outbound.clear()
            self._inbound.clear()
            if cut.visible:
                self._severed = LinkLost(self.name, "the line is cut")
        return cut is not None or self._severed is not None

    def _present_cut(self) -> Cut | None:
        return next((cut for cut in self._cuts if cut.covers(self.tick)), None)

    def _forward(self, block: bytes) -> None:
        if block:
            self._link.send(block)
