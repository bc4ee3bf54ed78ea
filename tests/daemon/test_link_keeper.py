from __future__ import annotations

from pathlib import Path

import pytest

from firmware_protocol.errors import LinkError
from firmware_protocol.links import (
    CanLinkConfig,
    Link,
    LinkState,
    SerialLinkConfig,
    UnixLink,
    UnixLinkConfig,
    memory_pair,
)
from firmware_protocol.links.link import LinkBasis
from gimbal_hil.loop.timing.clock import Duration, LockstepClock
from gimbal_hil.realtime.daemon.first_opening import PortConfig, comes_with_the_antenna, opener_of
from gimbal_hil.realtime.daemon.link_keeper import FIRST_WAIT, LONGEST_WAIT, LinkKeeper

BLOCK = bytes(10)
TICK = Duration(1_000_000)


class Told:
    """A keeper on a clock that is moved by hand, what it told, and when it tried to open."""

    def __init__(self, problems: int) -> None:
        self.clock = LockstepClock()
        self.problems = problems
        self.tries: list[int] = []
        self.said: list[tuple[bool, str]] = []
        self.here, self.there = memory_pair()
        self.keeper = LinkKeeper(self.clock, self.open, lambda is_open, text: self.said.append((is_open, text)))

    def open(self) -> Link:
        self.tries.append(self.clock.now_ns())
        if len(self.tries) <= self.problems:
            raise LinkError("link.port: no such port")
        return self.here

    def tick(self, count: int = 1) -> bytes:
        received = b""
        for _ in range(count):
            received += self.keeper.receive()
            self.keeper.send(BLOCK)
            self.clock.wait_until(self.clock.now() + TICK)
        return received


def test_a_port_that_is_not_there_is_tried_later_and_later_and_reported_once() -> None:
    told = Told(problems=1000)
    told.tick(20_000)
    pauses = [later - earlier for earlier, later in zip(told.tries, told.tries[1:], strict=False)]
    assert pauses[0] >= FIRST_WAIT.ns and pauses == sorted(pauses) and pauses[-1] == LONGEST_WAIT.ns
    assert told.said == [(False, "waiting for the link: link.port: no such port")]
    assert not told.keeper.is_open and told.keeper.losses == 0


def test_nothing_is_written_to_a_port_on_which_no_antenna_was_heard() -> None:
    told = Told(problems=0)
    told.tick(400)
    assert told.keeper.is_open and told.there.receive() == b""
    told.there.send(BLOCK)
    told.tick(2)
    assert told.there.receive()


def test_a_silent_port_is_not_written_to_any_more_and_then_closed_and_opened_anew() -> None:
    told = Told(problems=0)
    for _ in range(100):
        told.there.send(BLOCK)
        told.tick()
    assert told.there.receive()
    # the antenna was killed, and another program has its port now
    told.tick(600)
    told.there.receive()
    told.tick(1000)
    assert told.there.receive() == b"" and told.keeper.is_open
    here, there = memory_pair()
    told.here = here
    told.tick(2000)
    assert (False, "link lost: no whole frame for 2 s") in told.said and told.keeper.losses >= 1
    for _ in range(3000):
        there.send(BLOCK)
        told.tick()
    assert told.keeper.is_open and len(told.tries) >= 2 and there.receive()


def test_an_antenna_that_answers_only_is_spoken_to_first() -> None:
    told = Told(problems=0)
    told.here.speaks_first = False  # type: ignore[attr-defined]
    told.tick(5000)
    assert told.keeper.is_open and told.keeper.losses == 0 and told.there.receive()


def test_frames_pass_as_soon_as_the_port_is_there() -> None:
    told = Told(problems=2)
    told.tick(1000)
    assert told.keeper.is_open and told.said[-1] == (True, "link open")
    told.there.send(BLOCK)
    assert told.tick() == BLOCK
    assert told.there.receive()


class CutLink(LinkBasis):
    """A link that can be cut and whose return takes some tries."""

    def __init__(self) -> None:
        super().__init__("cut")
        self.away = 0
        self._opened()

    def cut(self, tries: int) -> None:
        self.away = tries
        self._lost("unplugged")

    def send(self, block: bytes) -> None:
        assert self.state is LinkState.OPEN

    def receive(self) -> bytes:
        assert self.state is LinkState.OPEN
        return BLOCK

    def _connect(self) -> None:
        self.away -= 1
        if self.away > 0:
            raise LinkError("unplugged")
        self._opened()

    def wait(self, timeout_ns: int) -> bool:
        return True

    def close(self) -> None:
        self._state = LinkState.CLOSED

    def fileno(self) -> int:
        return -1


def test_a_lost_link_is_reported_and_opened_again_and_nothing_is_sent_meanwhile() -> None:
    told = Told(problems=0)
    link = CutLink()
    keeper = LinkKeeper(told.clock, lambda: link, lambda is_open, text: told.said.append((is_open, text)))
    told.keeper = keeper
    assert told.tick(5000) == BLOCK * 5000
    link.cut(tries=3)
    assert told.tick(5) == b"" and not keeper.is_open
    assert told.tick(2000) != b"" and keeper.is_open
    assert keeper.losses == 1
    assert [text for _, text in told.said] == ["link open", "link lost: cut: unplugged", "link open"]
    keeper.close()
    assert link.state is LinkState.CLOSED


def test_time_in_link_calls_is_charged_to_the_link() -> None:
    told = Told(problems=0)
    charged: list[int] = []

    class SlowLink(CutLink):
        def send(self, block: bytes) -> None:
            told.clock.wait_until(told.clock.now() + Duration(700))

    link = SlowLink()
    told.keeper = LinkKeeper(told.clock, lambda: link, lambda is_open, text: None, charged.append)
    told.tick(10)
    assert sum(charged) == 7000


def test_a_listening_link_waits_without_complaint_until_somebody_connects(tmp_path: Path) -> None:
    told = Told(problems=0)
    path = tmp_path / "socket"
    told.keeper = LinkKeeper(
        told.clock, lambda: UnixLink(path, listen=True), lambda is_open, text: told.said.append((is_open, text))
    )
    told.tick(500)
    assert not told.keeper.is_open and len(told.said) == 1
    peer = UnixLink(path)
    for _ in range(5000):
        peer.send(BLOCK)
        told.tick()
    assert told.keeper.is_open
    peer.send(BLOCK)
    assert told.tick() == BLOCK
    told.keeper.close()
    peer.close()


def test_what_may_come_with_the_antenna_is_waited_for_and_the_rest_is_refused(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("")
    cases: list[tuple[PortConfig, bool]] = [
        (SerialLinkConfig(kind="serial", port=str(tmp_path / "antenna")), True),
        (SerialLinkConfig(kind="serial", port=str(tmp_path / "taken")), False),
        (SerialLinkConfig(kind="serial", port=str(tmp_path / "nowhere" / "antenna")), False),
        (SerialLinkConfig(kind="serial", port="/dev/ttyNotThere0"), False),
        (SerialLinkConfig(kind="serial", port="socket://127.0.0.1:1"), True),
        (UnixLinkConfig(kind="unix", path=tmp_path / "socket"), True),
        (UnixLinkConfig(kind="unix", path=tmp_path / "nowhere" / "socket"), False),
        (CanLinkConfig(kind="can", interface="slcan", channel=str(tmp_path / "antenna")), True),
        (CanLinkConfig(kind="can", interface="nobus", channel="can0"), False),
    ]
    for config, comes in cases:
        assert comes_with_the_antenna(config) is comes, config
        if comes:
            opener_of(config, wait=False)
        else:
            with pytest.raises(LinkError, match="link"):
                opener_of(config, wait=False)
        opener_of(config, wait=True)
