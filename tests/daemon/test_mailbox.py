from __future__ import annotations

import os
import subprocess
import sys

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from gimbal_hil.loop.timing.mailbox import RingReader, RingRecord, RingWriter, create_ring

pytestmark = pytest.mark.realtime


class RingMachine(RuleBasedStateMachine):
    """A reader that looks at any moment, also between the steps of a push, sees whole records, in order, and counts the
    lost ones.
    """

    @initialize(capacity=st.sampled_from([4096, 8192]))
    def open(self, capacity: int) -> None:
        self.descriptor = create_ring(capacity)
        self.writer = RingWriter(self.descriptor)
        self.reader = RingReader(self.descriptor)
        self.pushed: list[RingRecord] = []
        self.received: list[RingRecord] = []

    @rule(kind=st.integers(0, 2**32 - 2), payload=st.binary(max_size=700))
    def push(self, kind: int, payload: bytes) -> None:
        self.writer.push(kind, payload)
        self.pushed.append(RingRecord(kind, payload))

    @rule(count=st.integers(1, 60), size=st.integers(0, 900))
    def push_many(self, count: int, size: int) -> None:
        for index in range(count):
            self.push(index, bytes([index]) * size)

    @rule(kind=st.integers(0, 9), payload=st.binary(max_size=700), moment=st.integers(0, 2), most=st.integers(1, 9))
    def push_while_reading(self, kind: int, payload: bytes, moment: int, most: int) -> None:
        span = (24 + len(payload) + 7) & ~7
        position = self.writer._make_room(span)
        if moment == 0:
            self.take(most)
        self.writer._fill(position, kind, payload)
        if moment == 1:
            self.take(most)
        self.writer._publish(position + span)
        self.pushed.append(RingRecord(kind, payload))

    @rule(kind=st.integers(0, 9), payload=st.binary(max_size=700))
    def push_if_room(self, kind: int, payload: bytes) -> None:
        lost, pending = self.reader.lost, self.writer.backlog
        if self.writer.push_if_room(kind, payload):
            self.pushed.append(RingRecord(kind, payload))
            assert self.reader.lost == lost
        else:
            assert pending > 0

    @rule(most=st.integers(1, 100))
    def take(self, most: int) -> None:
        before = self.reader.lost
        for record in self.reader.take(most):
            self.received.append(record)
        assert self.reader.lost >= before

    @rule()
    def take_all(self) -> None:
        self.received += self.reader.take()
        assert self.reader.taken + self.reader.lost == len(self.pushed)
        assert self.writer.backlog == 0

    @invariant()
    def what_was_received_was_pushed_in_that_order(self) -> None:
        if hasattr(self, "pushed"):
            rest = iter(self.pushed)
            assert all(any(record == pushed for pushed in rest) for record in self.received)

    def teardown(self) -> None:
        if hasattr(self, "writer"):
            self.writer.close()
            self.reader.close()
            os.close(self.descriptor)


RingMachine.TestCase.settings = settings(max_examples=60, stateful_step_count=30, deadline=None)
TestRing = RingMachine.TestCase

WRITER = """
import sys
from gimbal_hil.loop.timing.mailbox import RingWriter
writer = RingWriter(int(sys.argv[1]))
for number in range(int(sys.argv[2])):
    writer.push(number % 7, b"%d " % number * (number % 50))
writer.push(99, b"end")
"""


def test_records_of_another_process_arrive_whole_while_it_overruns_a_slow_reader() -> None:
    count = 60_000
    descriptor = create_ring(16_384)
    reader = RingReader(descriptor)
    with subprocess.Popen(
        [sys.executable, "-c", WRITER, str(descriptor), str(count)], pass_fds=(descriptor,)
    ) as process:
        last, seen = -1, 0
        while True:
            for record in reader.take(5):
                if record.kind == 99:
                    break
                number = int(record.payload.split(b" ", 1)[0]) if record.payload else None
                if number is not None:
                    assert (
                        number > last
                        and record.kind == number % 7
                        and record.payload == b"%d " % number * (number % 50)
                    )
                    last = number
                seen += 1
            else:
                if process.poll() is None or reader.backlog:
                    continue
            break
    assert process.returncode == 0
    assert seen + reader.lost == count
    reader.close()
    os.close(descriptor)


def test_a_writer_without_any_reader_goes_on() -> None:
    descriptor = create_ring(4096)
    writer = RingWriter(descriptor)
    for _ in range(1000):
        writer.push(1, b"x" * 100)
    assert writer.pushed == 1000
    reader = RingReader(descriptor)
    kept = len(reader.take())
    assert 0 < kept < 1000 and reader.lost == 1000 - kept


def test_a_record_that_can_never_fit_is_refused_and_leaves_the_ring_as_it_was() -> None:
    writer = RingWriter(create_ring(4096))
    with pytest.raises(ValueError, match="does not fit"):
        writer.push(1, b"x" * 4000)
    assert not writer.push_if_room(1, b"x" * 4000)
    assert writer.pushed == 0


def test_push_if_room_overwrites_nothing_that_waits() -> None:
    descriptor = create_ring(4096)
    writer, reader = RingWriter(descriptor), RingReader(descriptor)
    accepted = sum(writer.push_if_room(1, b"x" * 100) for _ in range(200))
    assert 0 < accepted < 200
    assert len(reader.take()) == accepted and reader.lost == 0
    assert writer.push_if_room(1, b"x" * 100)


def test_a_damaged_record_is_not_handed_out() -> None:
    descriptor = create_ring(4096)
    writer, reader = RingWriter(descriptor), RingReader(descriptor)
    writer.push(1, b"torque off")
    writer._records[24] ^= 1
    assert reader.take() == []


def test_a_descriptor_without_a_ring_is_refused() -> None:
    from gimbal_hil.loop.timing.mailbox import anonymous_memory

    with pytest.raises(ValueError, match="record ring"):
        RingReader(anonymous_memory(4096))
