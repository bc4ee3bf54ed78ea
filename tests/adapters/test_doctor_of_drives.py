"""What `doctor` tells of drives that do not work: which one, what misses, and what to do about it."""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from firmware_protocol.adapters import CanFrame, ListenedBus, UnixCanBus
from firmware_protocol.links import AdapterLinkConfig, error_words, named_ports, problems_of
from gimbal_hil.realtime.daemon import check_link
from gimbal_hil.realtime.daemon.drive_check import DriveListener, HeardDrives
from gimbal_hil.surface.cli.doctor import REPORT_FILE
from sim_backend.drives import SimulatedCia402, SimulatedDrive, SimulatedMoteus, SimulatedOdrive
from tests.adapters.rig import settings_and_model
from tests.adapters.servo import SimulatedServo, mapped_files

pytestmark = pytest.mark.realtime

RATE_HZ = 200.0


class Bench:
    """Drives on a socket, answering and ticking in a thread until `close`."""

    def __init__(self, path: Path, drives: Sequence[SimulatedDrive]) -> None:
        self._bus, self._drives, self._over = UnixCanBus(path, listen=True), drives, threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def _serve(self) -> None:
        due = time.monotonic()
        while not self._over.wait(0.001):
            frames = [one for heard in self._bus.receive() for drive in self._drives for one in drive.hear(heard)]
            while due < time.monotonic():
                due += 1.0 / RATE_HZ
                frames += [one for drive in self._drives for one in drive.tick(1.0 / RATE_HZ)]
            for frame in frames:
                self._bus.send(frame)

    def close(self) -> None:
        self._over.set()
        self._thread.join()
        self._bus.close()


@pytest.fixture
def heard(tmp_path: Path) -> Iterator[Callable[..., HeardDrives]]:
    benches: list[Bench] = []

    def listen(make: str, drives: Sequence[SimulatedDrive], **more: Any) -> HeardDrives:
        benches.append(Bench(tmp_path / "drives", drives))
        listener = DriveListener(config_of(make, tmp_path / "drives", **more))
        end = time.monotonic() + 0.8
        while time.monotonic() < end:
            listener.link.wait(5_000_000)
            listener.link.receive()
        found = listener.judged()
        listener.link.close()
        return found

    yield listen
    for bench in benches:
        bench.close()


def config_of(make: str, path: Path, **more: Any) -> AdapterLinkConfig:
    each = {"torque_nm": 15.0, "counts_per_turn": 262144.0, "rated_torque_nm": 2.0} | more
    return AdapterLinkConfig.model_validate(
        {
            "kind": "adapter",
            "drive": make,
            "interface": "unix",
            "channel": str(path),
            "rate_hz": RATE_HZ,
            "drives": [{"id": 1} | each, {"id": 2} | each],
        }
    )


def drives_of(make: str, *numbers: int) -> list[SimulatedDrive]:
    built: dict[str, Callable[[int], SimulatedDrive]] = {
        "moteus": SimulatedMoteus,
        "odrive": SimulatedOdrive,
        "cia402": lambda number: SimulatedCia402(number, 2.0, 262144.0),
        "dbc": SimulatedServo,
    }
    return [built[make](number) for number in numbers]


@pytest.mark.parametrize("make", ["moteus", "odrive", "cia402", "dbc"])
def test_of_two_drives_the_one_that_is_dead_is_named_with_what_to_look_at(
    heard: Callable[..., HeardDrives], tmp_path: Path, make: str
) -> None:
    found = heard(make, drives_of(make, 1), **mapped_files(tmp_path, 200.0) if make == "dbc" else {})
    alive, dead = found.drives
    assert not alive.reasons and alive.heard_hz and alive.line.startswith("drive 1: ")
    assert dead.line == "drive 2: heard nothing of it"
    (reason,) = found.reasons
    assert reason.startswith("drive 2 says nothing: power, wiring")


@pytest.mark.parametrize("make", ["moteus", "odrive", "cia402"])
def test_a_drive_under_another_id_is_told_with_it(heard: Callable[..., HeardDrives], make: str) -> None:
    found = heard(make, drives_of(make, 1, 5))
    assert "a drive of id 5 answers; link.drives has those of id 1 and 2" in found.reasons


def test_an_object_that_is_refused_is_told_with_its_abort_code(heard: Callable[..., HeardDrives]) -> None:
    drives = [SimulatedCia402(1, 2.0, 262144.0), SimulatedCia402(2, 2.0, 262144.0, watches=False)]
    drives[0].objects._refusal = lambda index, *_: 0x0609_0030 if index == 0x6060 else 0  # type: ignore[method-assign]
    found = heard("cia402", drives)
    assert "drive 1: object 0x6060 refused, abort code 0x06090030 (value out of range)" in found.reasons
    assert (
        "drive 2 does not watch this side (object 0x1016 refused, abort code 0x06020000 (no such object))"
        in found.remarks
    )


class SlowOdrive(SimulatedOdrive):
    """Its encoder estimates are left at a tenth of the rate."""

    def tick(self, period_s: float) -> list[CanFrame]:
        return [frame for frame in super().tick(period_s) if frame.identifier & 0x1F != 0x09 or self._ticks % 10 == 0]


class MuteOdrive(SimulatedOdrive):
    """Its heartbeat is switched off."""

    def tick(self, period_s: float) -> list[CanFrame]:
        return [frame for frame in super().tick(period_s) if frame.identifier & 0x1F != 0x01]


def test_messages_that_come_too_seldom_or_not_at_all_are_told_with_their_setting(
    heard: Callable[..., HeardDrives],
) -> None:
    slow, silent = heard("odrive", [SlowOdrive(1), MuteOdrive(2)]).drives
    assert slow.reasons[0].startswith("drive 1 sends encoder estimates ")
    assert slow.reasons[0].endswith("200/s are needed: `config.can.encoder_msg_rate_ms` at the control rate")
    assert silent.reasons[0].startswith("drive 2 sends no heartbeat: ")


def test_a_fault_is_told_in_the_drive_s_own_word(heard: Callable[..., HeardDrives], tmp_path: Path) -> None:
    drives = drives_of("dbc", 1, 2)
    drives[1].trip()  # type: ignore[attr-defined]
    found = heard("dbc", drives, **mapped_files(tmp_path, 200.0))
    assert found.reasons == ["drive 2: State.State = 15 (Overcurrent)"]


def test_frames_that_cannot_be_sent_are_counted() -> None:
    class Full:
        slcan = None

        def send(self, frame: CanFrame) -> bool:
            return False

        def receive(self) -> list[CanFrame]:
            return [CanFrame(0x181, b"\x01"), CanFrame(0x181, b"\x02")]

    bus = ListenedBus(Full())  # type: ignore[arg-type]
    assert not bus.send(CanFrame(1, b"")) and bus.dropped == 1
    bus.receive()
    assert bus.heard == Counter({CanFrame(0x181, b""): 2}) and bus.refused == 0 and not bus.errors


def test_an_interface_that_is_down_slow_or_off_is_told_with_the_command_that_mends_it() -> None:
    def told(state: str, rate: int, *flags: str) -> dict[str, Any]:
        counts = {"tx": 248, "rx": 0}
        data = {"state": state, "bittiming": {"bitrate": rate}, "berr_counter": counts}
        return {"ifname": "can0", "flags": list(flags), "linkinfo": {"info_kind": "can", "info_data": data}}

    assert problems_of(told("ERROR-ACTIVE", 1_000_000, "NOARP", "UP"), "can0", 1_000_000) == []
    assert problems_of({}, "can0", 1_000_000) == []
    down, slow = problems_of(told("STOPPED", 500_000), "can0", 1_000_000)
    assert down == "can0 is down: sudo ip link set can0 up type can bitrate 1000000"
    assert "runs at 500000 bit/s, link.bitrate is 1000000" in slow
    (off,) = problems_of(told("BUS-OFF", 1_000_000, "UP"), "can0", 1_000_000)
    assert off.startswith("can0 is bus-off (errors sent 248, received 0): ")
    assert error_words(0x60) == ["no acknowledgement: nobody else on the bus, or at another bit rate", "bus-off"]
    assert error_words(0x200) == ["error frame"]


def test_serial_ports_are_listed_under_the_names_that_stay(tmp_path: Path) -> None:
    assert named_ports(tmp_path / "none") == []
    (tmp_path / "ttyACM7").touch()
    (tmp_path / "by-id").mkdir()
    (tmp_path / "by-id" / "usb-Acme_CAN-if00").symlink_to(tmp_path / "ttyACM7")
    (port,) = named_ports(tmp_path / "by-id")
    assert port == f"{tmp_path / 'ttyACM7'} ({tmp_path / 'by-id' / 'usb-Acme_CAN-if00'})"


def test_the_whole_check_has_each_drive_in_its_answer(tmp_path: Path) -> None:
    bench = Bench(tmp_path / "drives", drives_of("moteus", 1))
    try:
        link = config_of("moteus", tmp_path / "drives").model_dump(mode="json", exclude_none=True, by_alias=True)
        report = check_link(settings_and_model(link)[0])
    finally:
        bench.close()
    assert [one["id"] for one in report.as_dict()["drives"]] == [1, 2]  # type: ignore[index, attr-defined]
    assert any(line.startswith("drive 1: answer ") for line in report.lines()) and not report.good
    assert report.reasons[0].startswith("drive 2 says nothing: ") and REPORT_FILE == "doctor.json"
