"""What a receiver makes of counters and silence: ok, degraded, lost, and back."""

from __future__ import annotations

import numpy as np
import pytest

from firmware_protocol import block_codec, receiver
from firmware_protocol.codec import from_raw, pack, pack_raw, record
from firmware_protocol.mail import SET_POINT
from firmware_protocol.receiver import DUPLICATE, LATE_STEP, UNKNOWN_COUNTER, ReceiverStatus, judge_counter
from firmware_protocol.schema import BY_NAME, INDEX, MESSAGES, Direction

EVENT_MESSAGES = [message for message in MESSAGES if message.period_ticks == 0]
CYCLIC_MESSAGES = [message for message in MESSAGES if message.period_ticks]


class Bench:
    """One compiled receiver and the frames that a test sends it."""

    def __init__(self, message_name: str) -> None:
        self.message = BY_NAME[message_name]
        self.mail, self.receivers = block_codec.new_mail(), block_codec.new_receivers()
        self.raw = tuple(field.raw_high for field in self.message.fields)

    def tick(self, *counters: int, damage: int = 0) -> int:
        """One tick in which frames with these counters come; `damage` flips bits of their payloads."""
        block = b""
        for counter in counters:
            payload = int.from_bytes(pack_raw(self.message, self.raw, counter), "little") ^ damage
            block += record(self.message.can_id, payload.to_bytes(8, "little"))
        octets = np.array(list(block), dtype=np.uint8)
        return block_codec.receive_block(octets, len(block), self.mail, self.receivers, int(self.message.direction))

    def __getitem__(self, column: int) -> int:
        return int(self.receivers[INDEX[self.message.name], column])

    @property
    def status(self) -> ReceiverStatus:
        return ReceiverStatus(self[receiver.STATUS])


def test_a_message_never_heard_is_lost_and_the_first_good_frame_makes_it_ok():
    bench = Bench("set_point")
    bench.tick()
    assert bench.status is ReceiverStatus.LOST
    assert bench.tick(9) == 1
    assert bench.status is ReceiverStatus.OK


@pytest.mark.parametrize("message", CYCLIC_MESSAGES, ids=lambda message: message.name)
def test_silence_degrades_and_then_loses_a_message_by_its_own_period(message):
    bench = Bench(message.name)
    bench.tick(0)
    seen = []
    for _ in range(receiver.LOST_PERIODS * message.period_ticks + 1):
        bench.tick()
        seen.append(bench.status)
    degraded, lost = receiver.DEGRADED_PERIODS * message.period_ticks, receiver.LOST_PERIODS * message.period_ticks
    assert seen == [ReceiverStatus.OK] * degraded + [ReceiverStatus.DEGRADED] * (lost - degraded) + [
        ReceiverStatus.LOST
    ]
    bench.tick(0)
    assert bench.status is ReceiverStatus.OK


@pytest.mark.parametrize("message", EVENT_MESSAGES, ids=lambda message: message.name)
def test_an_event_message_is_not_lost_by_silence_but_forgets_its_counter(message):
    bench = Bench(message.name)
    bench.tick(5)
    assert bench.tick(5) == 0
    for _ in range(receiver.EVENT_MEMORY_TICKS + 1):
        bench.tick()
    assert bench.status is ReceiverStatus.OK
    assert bench.tick(5) == 1


def test_a_repeated_frame_changes_nothing_and_does_not_keep_a_message_alive():
    bench = Bench("set_point")
    bench.tick(4)
    for repeats in range(1, receiver.LOST_PERIODS + 1):
        assert bench.tick(4) == 0
        assert bench[receiver.DUPLICATES] == repeats
        assert bench.mail[SET_POINT] == 0
    assert bench.status is not ReceiverStatus.OK


def test_a_jump_of_the_counter_is_counted_as_lost_frames_and_the_value_is_taken():
    bench = Bench("set_point")
    bench.tick(14)
    assert bench.tick(2) == 1
    assert bench[receiver.LOST_FRAMES] == 3


def test_a_late_frame_never_overwrites_a_newer_one():
    bench = Bench("set_point")
    bench.tick(6)
    bench.tick(8)
    assert bench.tick(7) == 0
    assert bench[receiver.DUPLICATES] == 1


def test_every_counter_is_welcome_after_a_loss():
    for counter in range(16):
        bench = Bench("set_point")
        bench.tick(7)
        for _ in range(receiver.LOST_PERIODS + 1):
            bench.tick()
        assert bench.status is ReceiverStatus.LOST
        assert bench.tick(counter) == 1


def test_a_gap_that_could_be_mistaken_for_a_late_frame_always_ends_in_loss_first():
    # the steps judged late begin beyond what a message can miss before it is lost and takes every counter
    assert receiver.LOST_PERIODS + 1 < LATE_STEP
    for missing in range(200):
        bench = Bench("set_point")
        bench.tick(0)
        for _ in range(missing):
            bench.tick()
        assert bench.tick((missing + 1) % 16) == 1


def test_one_bad_frame_in_five_degrades_and_good_ones_heal():
    bench, counter = Bench("set_point"), 0
    for number in range(60):
        counter = (counter + 1) % 16
        bench.tick(counter, damage=1 if number % 3 == 0 else 0)
    assert bench.status is ReceiverStatus.DEGRADED
    assert bench[receiver.CRC_ERRORS] == 20
    for _ in range(receiver.TROUBLE_TOP):
        counter = (counter + 1) % 16
        bench.tick(counter)
    assert bench.status is ReceiverStatus.OK


def test_a_frame_with_a_wrong_crc_leaves_the_mail_alone():
    bench = Bench("set_point")
    for bit in range(64):
        assert bench.tick(0, damage=1 << bit) == 0
    assert not bench.mail.any()
    assert bench[receiver.CRC_ERRORS] == 64


def test_reset_after_a_reconnection_takes_any_counter_and_keeps_the_counts():
    bench = Bench("drive_event")
    bench.tick(3)
    block_codec.reset_receivers(bench.receivers)
    assert bench.status is ReceiverStatus.LOST
    assert bench.tick(3) == 1
    assert bench[receiver.GOOD] == 2


def test_several_frames_of_a_tick_leave_the_last_and_count_all():
    bench = Bench("set_point")
    assert bench.tick(0, 1, 2) == 3
    assert bench.mail[SET_POINT] == 3


def test_judging_counters():
    assert judge_counter(UNKNOWN_COUNTER, 11) == 0
    assert [judge_counter(3, (3 + step) % 16) for step in range(16)] == [
        DUPLICATE,
        *range(LATE_STEP - 1),
        *[DUPLICATE] * 4,
    ]


def test_typed_and_raw_packing_agree_for_every_message():
    for message in MESSAGES:
        raw = tuple(field.raw_low for field in message.fields)
        assert pack(from_raw(message, raw), 1) == pack_raw(message, raw, 1)
    assert {message.direction for message in MESSAGES} == set(Direction)
