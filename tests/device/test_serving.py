"""The virtual antenna on real pseudo-terminals and sockets: counts only, because the machine may be busy."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from firmware_protocol import mail as m
from firmware_protocol.enumerations import DriveState, FaultCode
from firmware_protocol.errors import BadInputError
from firmware_protocol.links import (
    CanLinkConfig,
    Link,
    LinkState,
    MemoryLink,
    SerialLinkConfig,
    UnixLinkConfig,
    memory_pair,
)
from firmware_protocol.messages import AnyMessage, DriveStatus, SetPoint
from firmware_protocol.opening import open_link
from firmware_protocol.schema import Direction
from sim_backend.device import Device
from sim_backend.server import DeviceServer, OutletKind, join_bus, open_outlet, parse_outlet
from tests.device.bench import bench_model, control
from tests.endpoints import Receiver, Sender

pytestmark = pytest.mark.realtime

PATIENCE_S = 30.0


class Host:
    """A host that sends a set-point a period and remembers what it heard."""

    def __init__(self, link: Link) -> None:
        self.link, self.sender, self.receiver = link, Sender(), Receiver(Direction.DEVICE_TO_HOST)
        self.heard: list[DriveStatus] = []
        self.sequence = 0

    def tick(self, *others: AnyMessage) -> None:
        self.sequence = (self.sequence + 1) % 1024
        self.link.send(self.sender.encode(*others, SetPoint(0.0, 0.0, self.sequence, True, True)))
        self.link.wait(2_000_000)
        self.listen()

    def listen(self) -> None:
        self.receiver.age()
        self.heard += [
            message for message in self.receiver.receive(self.link.receive()) if isinstance(message, DriveStatus)
        ]

    def tick_until(self, condition: Callable[[], bool], *others: AnyMessage) -> None:
        end = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < end, f"not in {PATIENCE_S} s; last heard {self.heard[-1:]}"
            self.tick(*others)

    def echoed(self) -> set[int]:
        return {status.last_sequence for status in self.heard}


@contextmanager
def served(link: Link, rate_hz: float = 500.0) -> Iterator[DeviceServer]:
    """A device served by a thread of its own."""
    server = DeviceServer(Device(bench_model(), rate_hz=rate_hz), link)
    thread = threading.Thread(target=server.serve)
    thread.start()
    try:
        yield server
    finally:
        server.stop()
        thread.join()
        link.close()


def _host_end(kind: OutletKind, path: str) -> Link:
    if kind is OutletKind.UNIX:
        return open_link(UnixLinkConfig(kind="unix", path=Path(path)))
    if kind is OutletKind.SLCAN:
        return open_link(CanLinkConfig(kind="can", interface="slcan", channel=path))
    return open_link(SerialLinkConfig(kind="serial", port=path))


@pytest.fixture(scope="module", autouse=True)
def compiled_device() -> None:
    """Compile before any clock runs."""
    Device(bench_model(), rate_hz=500.0).tick()


@pytest.mark.parametrize("kind", [OutletKind.SERIAL, OutletKind.SLCAN, OutletKind.UNIX])
def test_set_points_are_echoed_over_a_real_port_and_hosts_may_come_back(kind: OutletKind, tmp_path: Path) -> None:
    outlet = open_outlet(kind, tmp_path / "antenna")
    with served(outlet.link) as server:
        for _ in range(2):
            host = Host(_host_end(kind, outlet.path))
            host.tick_until(lambda host=host: len(host.echoed()) > 20)  # type: ignore[misc]
            # everything that the host believed had a good CRC and counter; nothing of it was foreign
            assert not host.receiver.strays
            host.link.close()
        # a set-point may still be under way when its host closes: what counts is ticks without one
        end = time.monotonic() + PATIENCE_S
        while server.statistics.ticks_by_own_clock < 10 and time.monotonic() < end:
            time.sleep(0.01)
    assert server.statistics.ticks_by_set_point + server.statistics.passed_over > 40
    assert server.statistics.ticks_by_own_clock >= 10
    assert server.statistics.bad_frames == 0
    assert not (tmp_path / "antenna").exists()


def test_on_a_can_bus_the_antenna_is_a_node_beside_the_host() -> None:
    config = CanLinkConfig(kind="can", interface="virtual", channel="antenna")
    outlet = join_bus(config)
    with served(outlet.link) as server:
        host = Host(open_link(config))
        host.tick_until(lambda: len(host.echoed()) > 20)
        host.link.close()
    # a set-point that came while this process stood still got its tick among the periods that are made up
    assert server.statistics.ticks_by_set_point + server.statistics.passed_over > 20
    assert server.statistics.bad_frames == 0


def test_a_host_that_dies_leaves_a_drive_in_fault_and_a_new_one_can_reset_it(tmp_path: Path) -> None:
    outlet = open_outlet(OutletKind.UNIX, tmp_path / "antenna")
    with served(outlet.link, rate_hz=100.0) as server:
        host = Host(_host_end(OutletKind.UNIX, outlet.path))
        for request, state in (
            (1, DriveState.READY_TO_SWITCH_ON),
            (2, DriveState.SWITCHED_ON),
            (3, DriveState.OPERATION_ENABLED),
        ):
            host.tick_until(lambda state=state: bool(host.heard) and host.heard[-1].state is state, control(request))  # type: ignore[misc, arg-type]
        host.link.close()
        end = time.monotonic() + PATIENCE_S
        while server.device.state is not DriveState.FAULT and time.monotonic() < end:
            time.sleep(0.01)
        assert server.device.fault is FaultCode.DEADMAN
        second = Host(_host_end(OutletKind.UNIX, outlet.path))
        for level, state in ((False, DriveState.FAULT), (True, DriveState.SWITCH_ON_DISABLED)):
            reset = control(fault_reset=level)
            second.tick_until(lambda state=state: bool(second.heard) and second.heard[-1].state is state, reset)  # type: ignore[misc]


class FakeTime:
    """A clock that only waiting moves."""

    def __init__(self) -> None:
        self.now_ns = 0

    def __call__(self) -> int:
        return self.now_ns


class TimedLink(MemoryLink):
    """A memory link in fake time: waiting lasts until the next block that the plan has, or the timeout."""

    clock: FakeTime
    plan: list[tuple[int, bytes]]

    def wait(self, timeout_ns: int) -> bool:
        due = self.clock.now_ns + timeout_ns
        if self.plan and self.plan[0][0] <= due:
            at, block = self.plan.pop(0)
            self.clock.now_ns = max(self.clock.now_ns, at)
            self._inbox.append(block)
            return True
        self.clock.now_ns = due
        return False


def _serve_plan(plan: list[tuple[int, bytes]], duration_ns: int) -> DeviceServer:
    _, far = memory_pair()
    link = TimedLink()
    link.peer, far.peer = far, link
    link.clock, link.plan = FakeTime(), plan
    server = DeviceServer(Device(bench_model()), link, link.clock)
    server.serve(duration_ns)
    return server


def test_every_set_point_of_a_steady_host_gets_its_own_tick() -> None:
    sender = Sender()
    plan = [
        (k * 1_000_000 - 400_000 + (k * 7919) % 300_000, sender.encode(SetPoint(0.0, 0.0, k % 1024, True, True)))
        for k in range(1, 2000)
    ]
    statistics = _serve_plan(plan, 2_000_000_000).statistics
    assert statistics.ticks_by_set_point == 1999
    assert (statistics.ticks_by_own_clock, statistics.skipped, statistics.merged, statistics.bad_frames) == (0, 0, 0, 0)


def test_the_antenna_goes_on_while_its_host_stalls_and_takes_the_newest_set_point_of_a_burst() -> None:
    sender = Sender()
    plan = [(k * 1_000_000, sender.encode(SetPoint(0.0, 0.0, k, True, True))) for k in range(1, 100)]
    burst = b"".join(sender.encode(SetPoint(0.0, 0.0, 100 + k, True, True)) for k in range(5))
    server = _serve_plan([*plan, (150_000_000, burst)], 151_000_000)
    assert server.statistics.ticks_by_set_point == 100
    assert server.statistics.ticks_by_own_clock == 50
    assert server.statistics.merged == 4
    assert server.device.mail[m.DRIVE_STATUS_LAST_SEQUENCE] == 104


class StalledLink(TimedLink):
    """A link whose process stands still for `stall_ns` when it first wants to sleep after `from_ns`."""

    from_ns, stall_ns = 50_000_000, 0

    def wait(self, timeout_ns: int) -> bool:
        if self.stall_ns and self.clock.now_ns >= self.from_ns:
            self.clock.now_ns, self.stall_ns = self.clock.now_ns + self.stall_ns, 0
            while self.plan and self.plan[0][0] <= self.clock.now_ns:
                self._inbox.append(self.plan.pop(0)[1])
            return True
        return super().wait(timeout_ns)


@pytest.mark.parametrize("stall_ms", [3, 30, 200])
def test_the_antennas_time_does_not_stand_still_while_its_process_does(stall_ms: int) -> None:
    sender, near, far = Sender(), StalledLink(), MemoryLink()
    near.peer, far.peer = far, near
    plan = [(k * 1_000_000, sender.encode(SetPoint(0.0, 0.0, k % 1024, True, True))) for k in range(1, 400)]
    near.clock, near.plan, near.stall_ns = FakeTime(), plan, stall_ms * 1_000_000
    server = DeviceServer(Device(bench_model()), near, near.clock)
    statistics = server.serve(400_000_000)
    assert statistics.skipped == statistics.passed_over
    assert abs(statistics.passed_over - stall_ms) <= 1
    assert abs(server.device.ticks - 399) <= 1
    # every set-point had its own tick, and the last one is in force
    assert statistics.merged <= 1 and statistics.bad_frames == 0 and server.device.set_points[0] >= 398
    assert server.device.mail[m.DRIVE_STATUS_LAST_SEQUENCE] == 399
    assert server.device.fault is not FaultCode.DEADMAN


def test_an_antenna_whose_process_stood_still_for_longer_is_carried_over_two_seconds() -> None:
    near, far = StalledLink(), MemoryLink()
    near.peer, far.peer = far, near
    near.clock, near.plan, near.stall_ns = FakeTime(), [], 10_000_000_000
    server = DeviceServer(Device(bench_model()), near, near.clock)
    statistics = server.serve(11_000_000_000)
    assert statistics.passed_over == 2000 and 9_990 <= statistics.skipped <= 10_000
    assert server.device.ticks == statistics.ticks


@pytest.mark.parametrize("text", ["", "serial:", "unix", "unix:", "can0", "tcp:1.2.3.4"])
def test_a_link_that_does_not_exist_is_refused_with_what_would_do(text: str) -> None:
    with pytest.raises(BadInputError, match="expected serial, slcan"):
        parse_outlet(text)


@contextmanager
def _command(*options: str) -> Iterator[subprocess.Popen[str]]:
    """`gimbal-hil plant` in a process of its own, gone at the end whatever happens."""
    command = [sys.executable, "-c", "from gimbal_hil.surface.cli import main; main()", "plant", *options]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 130), (signal.SIGINT, 130), (None, 0)])
def test_the_command_announces_its_path_and_ends_cleanly(
    number: signal.Signals | None, code: int, tmp_path: Path
) -> None:
    antenna, ready = tmp_path / "antenna", tmp_path / "ready"
    options = ["--duration", "0.3"] if number is None else []
    with _command("--link", f"serial:{antenna}", "--ready-file", str(ready), "--json", *options) as process:
        assert process.stdout is not None
        first = json.loads(process.stdout.readline())
        assert first["path"] == str(antenna)
        if number is not None:
            assert ready.read_text().strip() == first["path"]
            host = Host(_host_end(OutletKind.SERIAL, first["path"]))
            host.tick_until(lambda: len(host.echoed()) > 5)
            host.link.close()
            process.send_signal(number)
        rest = process.stdout.read()
        assert process.wait() == code
    last = json.loads(rest)
    assert last["event"] == "done"
    assert last["ticks"] > 0
    assert not ready.exists()
    assert not antenna.is_symlink()


def test_a_lost_link_is_opened_again_and_does_not_spin() -> None:
    near, far = memory_pair()
    clock = FakeTime()
    asleep: list[int] = []

    class Lost(MemoryLink):
        reopened = 0

        @property
        def state(self) -> LinkState:
            return LinkState.LOST

        def wait(self, timeout_ns: int) -> bool:
            asleep.append(timeout_ns)
            clock.now_ns += timeout_ns
            return False

        def reopen(self) -> bool:
            Lost.reopened += 1
            return False

    link = Lost()
    link.peer, near.peer = far, far
    DeviceServer(Device(bench_model()), link, clock).serve(1_000_000_000)
    assert Lost.reopened in (10, 11)
    assert len(asleep) == 1000
