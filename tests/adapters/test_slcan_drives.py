"""Drives of other makes behind an slcan adapter: acknowledgements, noise and a broken line never become old feedback, a
fault by itself or a traceback; and a port in use hears nothing of a second host.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator

import pytest

from firmware_protocol.adapters import AdapterLink, CanFrame, PythonCanBus
from firmware_protocol.errors import LinkError
from firmware_protocol.links import AdapterLinkConfig, BusClaim, CanLinkConfig, LinkState
from firmware_protocol.opening import open_link
from gimbal_hil.loop.host import HostState
from gimbal_hil.realtime.daemon import check_link
from tests.adapters.rig import PERIOD_NS, AdapterRig, link_section, settings_and_model
from tests.adapters.slcan_stand import SlcanStand

pytestmark = [pytest.mark.realtime]

DRIVES = ["moteus", "odrive", "cia402"]
#: broken text, a bell, a byte that is no letter, a line without end
NOISE = b"t1\xff2zz8\r\a\r\x80\rT0\r"
#: opens a port as `how` says, tells so, and stays
HOLDER = """
import sys, os, fcntl, time
port = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
if sys.argv[2] == "locked":
    fcntl.flock(port, fcntl.LOCK_EX)
print("open", flush=True)
time.sleep(60)
"""


@pytest.fixture
def stand() -> Iterator[SlcanStand]:
    one = SlcanStand()
    yield one
    one.close()


def rig_on(stand: SlcanStand, drive: str) -> AdapterRig:
    return AdapterRig(drive, far=stand, bus_more={"interface": "slcan", "channel": stand.path})


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("noise", [b"", NOISE], ids=["acknowledged", "noise too"])
def test_drives_are_moved_as_on_any_other_bus(stand, drive, noise):
    rig = rig_on(stand, drive)
    stand.noise = noise
    rig.connected()
    assert rig.position(0.2, 0.1).run(1200).host.state is HostState.ACTIVE, rig.events
    assert rig.joints == pytest.approx([0.2, 0.1], abs=0.01)
    # a pseudo-terminal may hand a tick's octets over with the next one; none is ever older
    assert not any("to lost" in event or "fault" in event for event in rig.events), rig.events
    assert bool(rig.link.statistics.malformed) == bool(noise)
    rig.link.close()


def test_everything_that_has_come_is_read_in_one_call_however_often_the_adapter_acknowledged(stand):
    bus = PythonCanBus("slcan", stand.path, 1_000_000)
    sent = [CanFrame(number, bytes(8)) for number in range(100)]
    for frame in sent:
        stand.say(b"z\r\rZ\r\a")
        stand.send(frame)
    assert bus.receive() == sent
    bus.close()


@pytest.mark.parametrize("drive", DRIVES)
def test_a_line_that_breaks_in_motion_is_a_lost_link_with_a_reason(drive):
    stand = SlcanStand()
    rig = rig_on(stand, drive).connected().position(0.5, 0.2)
    rig.run(100)
    stand.close()
    for _ in range(20):
        rig.link.send(rig.host.tick(rig.number, rig.number * PERIOD_NS, rig.link.receive()))
        rig.number += 1
    assert rig.link.state is LinkState.LOST and rig.link.loss is not None and rig.link.loss.reason
    assert rig.host.state is HostState.FAULT and any("feedback" in event for event in rig.events + _texts(rig))
    assert not rig.link.reopen()


def _texts(rig: AdapterRig) -> list[str]:
    return [event.text for event in rig.host.events()]


@pytest.fixture(params=["locked", "without a lock"])
def holder(request, stand) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [sys.executable, "-c", HOLDER, stand.path, request.param], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None and process.stdout.readline() == "open\n"
    yield process
    process.kill()
    process.wait()
    process.stdout.close()


def test_a_port_in_use_hears_nothing_of_a_second_host_which_is_told_who_has_it(stand, holder):
    section = link_section("odrive") | {"interface": "slcan", "channel": stand.path}
    drives = AdapterLinkConfig.model_validate(section)
    own = CanLinkConfig(kind="can", interface="slcan", channel=stand.path)
    for config in (drives, own):
        with pytest.raises(LinkError, match=rf"busy: process {holder.pid} \(python") as caught:
            open_link(config)
        assert "\n" not in str(caught.value)
    settings, _ = settings_and_model(section)
    assert f"busy: process {holder.pid}" in check_link(settings).reasons[0]
    assert stand.receive() == [] and stand.heard == []


def test_the_port_is_free_again_when_its_holder_closes_it(stand):
    for _ in range(2):
        bus = PythonCanBus("slcan", stand.path, 1_000_000)
        with pytest.raises(LinkError, match="busy: process"):
            PythonCanBus("slcan", stand.path, 1_000_000)
        bus.close()


def test_listening_to_drives_does_not_let_go_of_what_another_program_holds():
    rig = AdapterRig("odrive")
    config = rig.settings.link
    assert isinstance(config, AdapterLinkConfig)
    rig.connected()
    listener = AdapterLink(config)
    for _ in range(50):
        listener.receive()
        rig.run(1)
    listener.close()
    rig.position(0.1, 0.1).run(300)
    assert rig.host.state is HostState.ACTIVE, rig.events
    rig.far.receive() if rig.far is not None else None
    AdapterLink(config).close()
    rig.run(50)
    assert rig.host.state is HostState.ACTIVE, rig.events
    rig.close()


def test_a_bus_that_any_program_may_open_has_one_host():
    first = BusClaim("socketcan a bus of this test")
    with pytest.raises(LinkError, match=r"socketcan a bus of this test: busy: process \d+"):
        BusClaim("socketcan a bus of this test")
    first.release()
    BusClaim("socketcan a bus of this test").release()
