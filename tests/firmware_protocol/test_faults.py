"""The faulty link does what its configuration says, reproducibly, and the codec above it yields true values or none."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.links import Cut, DirectionFaults, FaultsConfig, FaultyLink, LinkState, memory_pair
from firmware_protocol.messages import SetPoint
from firmware_protocol.schema import RECORD_SIZE, Direction
from tests.endpoints import Receiver, Sender

TICKS = 200

faults_of_every_kind = st.builds(
    DirectionFaults,
    drop=st.floats(0, 0.5),
    duplicate=st.floats(0, 0.5),
    reorder=st.floats(0, 0.5),
    corrupt=st.floats(0, 0.5),
    corrupt_bits=st.integers(1, 80),
    truncate=st.floats(0, 0.5),
    delay=st.floats(0, 0.5),
    delay_ticks=st.integers(1, 40),
)


def records_of(block: bytes) -> list[bytes]:
    return [block[at : at + RECORD_SIZE] for at in range(0, len(block), RECORD_SIZE)]


def story(
    faults: DirectionFaults, seed: int = 1, cuts: tuple[Cut, ...] = (), ticks: int = TICKS
) -> tuple[list[bytes], list[bytes]]:
    """Blocks sent and blocks received, tick by tick, one set-point a tick through the receiving side's faults."""
    near, far = memory_pair()
    link = FaultyLink(near, FaultsConfig(seed=seed, receive=faults, cuts=cuts))
    sender, sent, received = Sender(), [], []
    for tick in range(ticks):
        sent.append(sender.encode(SetPoint(tick * 0.001, 0.0, tick % 1024, True, True)))
        far.send(sent[-1])
        received.append(link.receive())
    return sent, received


def test_without_faults_everything_passes_as_it_was():
    sent, received = story(DirectionFaults())
    assert sent == received


@given(faults_of_every_kind, st.integers(0, 2**31))
@settings(max_examples=20, deadline=None)
def test_the_same_seed_gives_the_same_faults(faults, seed):
    assert story(faults, seed) == story(faults, seed)


def test_another_seed_gives_other_faults_and_the_directions_differ():
    faults = DirectionFaults(drop=0.3)
    assert story(faults, 1) != story(faults, 2)
    near, far = memory_pair()
    link = FaultyLink(near, FaultsConfig(seed=1, send=faults))
    arrived = []
    for block in story(faults, 1)[0]:
        link.send(block)
        arrived.append(far.receive())
        link.receive()
    assert arrived != story(faults, 1)[1]


def test_drop_loses_about_the_configured_share():
    _, received = story(DirectionFaults(drop=0.25), ticks=2000)
    assert 0.2 < received.count(b"") / 2000 < 0.3


def test_duplicate_doubles_frames_and_the_receiver_counts_them_once():
    sent, received = story(DirectionFaults(duplicate=1.0))
    assert received == [block * 2 for block in sent]
    receiver = Receiver(Direction.HOST_TO_DEVICE)
    assert len(receiver.receive(b"".join(received))) == TICKS


def test_reorder_lets_the_next_frame_overtake():
    sent, received = story(DirectionFaults(reorder=0.3), ticks=500)
    flat = records_of(b"".join(received))
    assert set(flat) <= set(sent) and len(flat) >= 499
    places = [sent.index(record) for record in flat]
    assert places != sorted(places)


def test_delay_brings_frames_so_many_ticks_later():
    sent, received = story(DirectionFaults(delay=1.0, delay_ticks=7))
    assert received[7:] == sent[:-7] and not any(received[:7])


def test_corrupt_changes_exactly_the_configured_bits():
    sent, received = story(DirectionFaults(corrupt=1.0, corrupt_bits=1))
    for before, after in zip(sent, received, strict=True):
        assert (int.from_bytes(before, "little") ^ int.from_bytes(after, "little")).bit_count() == 1


def test_truncate_shortens_blocks():
    sent, received = story(DirectionFaults(truncate=1.0))
    assert all(before.startswith(after) for before, after in zip(sent, received, strict=True))
    assert len({len(after) for after in received}) > 5


def test_a_cut_stops_everything_for_its_ticks_and_nothing_of_it_comes_later():
    sent, received = story(DirectionFaults(), cuts=(Cut(start_tick=10, ticks=5),))
    assert not any(received[9:14])
    assert received[:9] == sent[:9] and received[14:] == sent[14:]


def test_a_visible_cut_is_a_lost_port_until_it_is_over_and_reopened():
    near, far = memory_pair()
    link = FaultyLink(near, FaultsConfig(cuts=(Cut(start_tick=2, ticks=3, visible=True),)))
    states = []
    for _ in range(8):
        link.receive()
        states.append(link.state)
        if link.tick == 4:
            assert link.reopen() is False
            assert link.loss is not None and "cut" in str(link.loss)
    assert states == [LinkState.OPEN] + [LinkState.LOST] * 7
    far.send(b"0123456789")
    assert link.receive() == b""
    assert link.reopen() is True
    far.send(b"0123456789")
    assert link.receive() == b"0123456789"


@given(faults_of_every_kind, st.integers(0, 2**31))
@settings(max_examples=60, deadline=None)
def test_through_any_faults_the_codec_yields_true_values_or_nothing(faults, seed):
    near, far = memory_pair()
    link = FaultyLink(near, FaultsConfig(seed=seed, send=faults, receive=faults))
    sender, receiver = Sender(), Receiver(Direction.HOST_TO_DEVICE)
    sent, good = [], []
    for tick in range(TICKS):
        sent.append(SetPoint(tick * 0.001, -tick * 0.001, tick, bool(tick & 1), True))
        far.send(sender.encode(sent[-1]))
        receiver.age()
        good += receiver.receive(link.receive())
    assert all(sent[message.sequence] == message for message in good)
    assert receiver.receptions[0x20].good == len(good)
