"""Sending and receiving end of the wire as objects, with the counters and verdicts that `block_codec` keeps in
arrays.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from firmware_protocol.codec import Rejection, alive_counter, from_raw, pack, record, records, schema_of, unpack_raw
from firmware_protocol.messages import AnyMessage
from firmware_protocol.receiver import (
    DUPLICATE,
    UNKNOWN_COUNTER,
    ReceiverStatus,
    judge_counter,
    judge_status,
    memory_ticks,
    more_trouble,
)
from firmware_protocol.schema import BY_CAN_ID, MESSAGES, RECORD_SIZE, Direction, Message


@dataclass
class Sender:
    """Alive counters of one end."""

    counters: dict[str, int] = field(default_factory=dict)

    def encode(self, *messages: AnyMessage) -> bytes:
        """Block of these messages, in order; each one's counter goes on by one."""
        block = []
        for message in messages:
            definition = schema_of(message)
            counter = self.counters.get(definition.name, 0)
            self.counters[definition.name] = (counter + 1) & 15
            block.append(record(definition.can_id, pack(message, counter)))
        return b"".join(block)


@dataclass
class Reception:
    """What one receiver knows of one message."""

    definition: Message
    last_counter: int = UNKNOWN_COUNTER
    good: int = 0
    lost: int = 0
    ticks_since_good: int = 0
    trouble: int = 0
    rejected: dict[Rejection, int] = field(default_factory=dict)
    latest: AnyMessage | None = None

    @property
    def status(self) -> ReceiverStatus:
        """How far the message can be relied on now."""
        return ReceiverStatus(
            judge_status(self.definition.period_ticks, self.ticks_since_good, self.trouble, int(self.good > 0))
        )

    def age(self) -> None:
        """Let one tick pass."""
        self.ticks_since_good += 1
        if self.ticks_since_good > memory_ticks(self.definition.period_ticks):
            self.last_counter = UNKNOWN_COUNTER

    def take(self, payload: bytes) -> AnyMessage | Rejection:
        """Judge one payload; only a good one changes `latest`."""
        raw = unpack_raw(self.definition, payload)
        if raw is Rejection.BAD_CRC or raw is Rejection.WRONG_LENGTH:
            return self._reject(raw, 1)
        lost = judge_counter(self.last_counter, alive_counter(payload))
        if lost == DUPLICATE:
            return self._reject(Rejection.DUPLICATE, 0)
        if isinstance(raw, Rejection):
            return self._reject(raw, 1)
        self.last_counter, self.ticks_since_good = alive_counter(payload), 0
        self.good += 1
        self.lost += lost
        self.trouble = max(0, more_trouble(self.trouble, lost) - 1)
        self.latest = from_raw(self.definition, raw)
        return self.latest

    def _reject(self, why: Rejection, frames: int) -> Rejection:
        self.rejected[why] = self.rejected.get(why, 0) + 1
        self.trouble = more_trouble(self.trouble, frames)
        return why


class Receiver:
    """Receiving end of one direction: the same verdicts as `block_codec.receive_block`, as objects."""

    def __init__(self, direction: Direction) -> None:
        self.direction = direction
        self.receptions = {message.can_id: Reception(message) for message in MESSAGES if message.direction is direction}
        self.strays: dict[Rejection, int] = {}

    def age(self) -> None:
        """Let one tick pass for every message."""
        for reception in self.receptions.values():
            reception.age()

    def receive(self, block: bytes) -> list[AnyMessage]:
        """Good messages of a block, in order; everything else is counted."""
        good: list[AnyMessage] = []
        for can_id, payload in records(block):
            reception = self.receptions.get(can_id)
            if reception is None:
                self._stray(Rejection.WRONG_DIRECTION if can_id in BY_CAN_ID else Rejection.UNKNOWN_IDENTIFIER)
                continue
            message = reception.take(payload)
            if not isinstance(message, Rejection):
                good.append(message)
        if len(block) % RECORD_SIZE:
            self._stray(Rejection.TRUNCATED)
        return good

    def _stray(self, why: Rejection) -> None:
        self.strays[why] = self.strays.get(why, 0) + 1
