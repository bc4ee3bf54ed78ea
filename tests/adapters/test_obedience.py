"""A gateway tells what its drives say: orders are repeated until they do, and who does not is left to its watchdog."""

from __future__ import annotations

import itertools
import struct
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.adapters import CanFrame, Power
from firmware_protocol.adapters.cia402 import state_of
from firmware_protocol.adapters.obedience import Obedience, Order
from firmware_protocol.enumerations import DriveState, FaultCode
from gimbal_hil.loop.host import HostState
from sim_backend.drives import SimulatedCia402
from tests.adapters.rig import AdapterRig
from tests.adapters.told import Told
from tests.parts import heavy_but

QUICK_STOP, DISABLE = 0x02, 0x00


def drives(watches: bool = True, **objects: int) -> list[SimulatedCia402]:
    """Two that are set up like the rig's, with values of their objects."""
    made = [SimulatedCia402(number, 2.0, 262144.0, watches) for number in (1, 2)]
    for drive in made:
        for name, value in objects.items():
            drive.objects[int(name[1:], 16), 0] = value
    return made


@pytest.fixture
def rigs() -> Iterator[Callable[..., AdapterRig]]:
    made: list[AdapterRig] = []

    def build(**settings_: object) -> AdapterRig:
        made.append(AdapterRig("cia402", **settings_))  # type: ignore[arg-type]
        return made[-1]

    yield build
    for rig in made:
        rig.close()


def is_command(frame: CanFrame, *words: int) -> bool:
    """Whether a frame is a controlword of these."""
    of_a_drive = 0x200 < frame.identifier < 0x280 and len(frame.data) == 4
    return of_a_drive and struct.unpack_from("<H", frame.data)[0] in words


def loses(count: int, *words: int) -> Callable[[CanFrame], bool]:
    """A bus that loses the first so many of these controlwords for each drive."""
    lost = {0x201: 0, 0x202: 0}

    def unheard(frame: CanFrame) -> bool:
        if is_command(frame, *words) and lost[frame.identifier] < count:
            lost[frame.identifier] += 1
            return True
        return False

    return unheard


@pytest.mark.parametrize("count", [1, 15])
def test_a_stop_that_is_lost_is_told_again(rigs: Callable[..., AdapterRig], count: int) -> None:
    rig = rigs().connected().torque(0.5, 0.0).run(200)
    start = float(rig.joints[0])
    rig.unheard = loses(count, QUICK_STOP)
    rig.host.quick_stop()
    # a state is told only once the drives have: until then they follow
    for _ in range(count):
        rig.run(1)
        assert rig.gateway.state is DriveState.OPERATION_ENABLED
        assert {drive.status for drive in rig.gimbal.drives} == {0x27}
    rig.run(3)
    assert rig.gateway.state is DriveState.QUICK_STOP_ACTIVE and rig.only_brakes()
    rig.run(2000)
    # with option 2 a stop ends by itself, and that is told too
    assert rig.gateway.state is DriveState.SWITCH_ON_DISABLED and rig.has_no_torque()
    assert abs(float(rig.joints[0]) - start) < 0.5


@pytest.mark.parametrize("watches", [True, False], ids=["watches", "refuses 0x1016"])
def test_a_drive_that_does_not_obey_is_stopped_by_its_own_watchdog(
    rigs: Callable[..., AdapterRig], watches: bool
) -> None:
    rig = rigs(drives=drives(watches)).connected().torque(0.5, 0.0).run(200)
    start = float(rig.joints[0])
    # every stop and every release to the first drive is lost, and nothing else
    rig.unheard = lambda frame: frame.identifier == 0x201 and is_command(frame, QUICK_STOP, DISABLE)
    rig.host.quick_stop()
    rig.run(25)
    assert rig.gateway.state is DriveState.FAULT_REACTION_ACTIVE and rig.gateway.fault is FaultCode.INTERNAL
    assert "drive 1: " in rig.link.complaint and "told to stop, says on after 20 ms" in rig.link.complaint
    assert "drive 2: " not in rig.link.complaint or not watches
    rig.run(25)
    assert rig.only_brakes() and rig.gimbal.drives[0].status in (0x0F, 0x08)  # type: ignore[attr-defined]
    rig.run(2000)
    assert rig.has_no_torque() and rig.gateway.state is DriveState.FAULT
    assert abs(float(rig.joints[0]) - start) < 0.5
    rig.unheard = lambda frame: False
    rig.host.reset_fault()
    rig.run(600)
    assert rig.host.state is HostState.IDLE, rig.events[-5:]


@pytest.mark.parametrize("option", heavy_but((6,), range(9)))
def test_reset_leads_out_of_a_quick_stop_whatever_its_option(rigs: Callable[..., AdapterRig], option: int) -> None:
    rig = rigs(drives=drives(x605A=option)).connected().position(0.4, -0.3).run(150)
    rig.host.quick_stop()
    rig.run(1500)
    stays = option >= 5
    assert rig.gateway.state is (DriveState.QUICK_STOP_ACTIVE if stays else DriveState.SWITCH_ON_DISABLED)
    assert {drive.status for drive in rig.gimbal.drives} == {0x07 if stays else 0x40}
    rig.host.reset_fault()
    rig.run(600)
    assert rig.host.state is HostState.IDLE, rig.events[-5:]
    rig.position(0.1, 0.1).run(2500)
    np.testing.assert_allclose(rig.joints, (0.1, 0.1), atol=2e-3)


@pytest.mark.parametrize("option", range(4))
def test_a_fault_is_told_once_the_reaction_to_it_is_over(rigs: Callable[..., AdapterRig], option: int) -> None:
    rig = rigs(drives=drives(x605E=option)).connected().position(0.4, -0.3).run(150)
    tripped = rig.gimbal.drives[1]
    tripped.trip(0x2310)  # type: ignore[attr-defined]
    told = []
    for _ in range(1500):
        rig.run(1)
        told.append((rig.gateway.state, rig.has_no_torque()))
    assert (DriveState.FAULT, False) not in told and told[-1] == (DriveState.FAULT, True)
    assert any(state is DriveState.FAULT_REACTION_ACTIVE for state, _ in told)
    assert "drive 2: error 0x2310" in rig.link.complaint


def test_a_drive_that_stops_by_itself_is_not_enabled_by_the_next_set_point(rigs: Callable[..., AdapterRig]) -> None:
    rig = rigs(drives=drives(x605A=6)).connected().position(0.4, -0.3).run(150)
    first = rig.gimbal.drives[0]
    first._stop_quickly()  # type: ignore[attr-defined]
    # this side hears of it a tick later
    rig.unheard = loses(2, 0x0F)
    for _ in range(100):
        rig.run(1)
        assert first.status != 0x27  # type: ignore[attr-defined]
    assert rig.host.state is HostState.FAULT and rig.gateway.fault is FaultCode.INTERNAL


def test_a_drive_under_torque_that_nobody_asked_for_is_switched_off(rigs: Callable[..., AdapterRig]) -> None:
    rig = rigs().run(20)
    assert rig.gateway.state is DriveState.SWITCH_ON_DISABLED
    rig.connected()
    rig.host.quick_stop()
    rig.run(100)
    assert rig.gateway.state is DriveState.SWITCH_ON_DISABLED
    rig.gimbal.drives[0].status = 0x27  # type: ignore[attr-defined]
    rig.run(3)
    assert rig.gimbal.drives[0].status == 0x40  # type: ignore[attr-defined]


def test_a_drive_that_starts_anew_is_set_up_again_and_never_enabled_without_reset(
    rigs: Callable[..., AdapterRig],
) -> None:
    rig = rigs().connected().position(0.4, -0.3).run(150)
    first = rig.gimbal.drives[0]
    first.start_anew()  # type: ignore[attr-defined]
    rig.run(300)
    assert rig.host.state is HostState.FAULT and rig.has_no_torque()
    rig.host.reset_fault()
    rig.run(800)
    assert rig.host.state is HostState.IDLE, rig.events[-5:]


@pytest.mark.parametrize("of_the_answers", [False, True])
@pytest.mark.parametrize("number", heavy_but((7,), range(18)))
def test_a_drive_whose_set_up_loses_a_frame_is_set_up_all_the_same(
    rigs: Callable[..., AdapterRig], number: int, of_the_answers: bool
) -> None:
    seen = itertools.count()
    identifier = 0x581 if of_the_answers else 0x601

    def loses_one(frame: CanFrame) -> bool:
        return frame.identifier == identifier and next(seen) == number

    rig = rigs(**{"lost" if of_the_answers else "unheard": loses_one})
    rig.run(800)
    assert rig.host.state is HostState.IDLE, rig.events[-5:]
    # it is whole: what is commanded is done
    assert rig.position(0.1, 0.1).run(2500).host.state is HostState.ACTIVE
    np.testing.assert_allclose(rig.joints, (0.1, 0.1), atol=2e-3)


@given(
    words=st.lists(st.one_of(st.none(), st.sampled_from(Power)), min_size=1, max_size=80)
    | st.lists(st.sampled_from((None, Power.ON)), min_size=30, max_size=80),
    stop=st.booleans(),
    asked_again=st.booleans(),
)
@settings(max_examples=300, deadline=None)
def test_an_order_is_repeated_until_a_newer_word_and_nobody_is_fed_who_does_not_obey(
    words: list[Power | None], stop: bool, asked_again: bool
) -> None:
    drive = Told()
    drive.says(Power.OFF)
    obedience = Obedience([drive], 1e-3)
    order = Order.STOP if stop else Order.RELEASE
    obedience.give(order)
    told = b"stop" if stop else b"release"
    assert not obedience.is_done() and not obedience.without_torque()
    late = 0
    for number, word in enumerate(words):
        if asked_again:
            obedience.give(order)  # the one that stands: its time goes on
        was_starving, gives_up = obedience.starving, obedience.gave_up()
        given_up = gives_up or was_starving
        assert given_up == obedience.starving and not (gives_up and was_starving)
        sent = [frame.data for frame in obedience.frames()]
        heeds = obedience.is_done()
        late = 0 if heeds else late + 1
        assert given_up == (b"starved" in sent) == (b"fed" not in sent)
        if not given_up and (number == 0 or not heeds):
            assert told in sent
        assert not (late > 20 + 1 and not obedience.starving)
        complaint = obedience.complaint(0)
        assert ("says nothing" in complaint) == (late > 20 and not any(words[:number]))
        if word is not None:
            drive.says(word)
        if obedience.is_done():
            assert any(said is not None for said in words[: number + 1])
            assert drive.sample.power not in ((Power.ON,) if stop else (Power.ON, Power.STOPPING))
    obedience.give(Order.FOLLOW)
    obedience.give(order)
    assert b"starved" not in [frame.data for frame in obedience.frames()]


def test_a_drive_that_reacts_to_a_fault_is_told_the_order_at_every_tick() -> None:
    drive = Told()
    drive.says(Power.ON)
    obedience = Obedience([drive], 1e-3)
    obedience.give(Order.RELEASE)
    drive.says(Power.REACTING)
    assert obedience.is_done()
    for _ in range(3):
        assert [frame.data for frame in obedience.frames()] == [b"release", b"fed"]
    drive.says(Power.OFF)
    assert [frame.data for frame in obedience.frames()] == [b"fed"]


@pytest.mark.parametrize("power", Power)
def test_a_drive_is_told_nothing_before_the_first_order(power: Power) -> None:
    drive = Told()
    drive.says(power)
    assert [frame.data for frame in Obedience([drive], 1e-3).frames()] == [b"fed"]


STATES = (0x40, 0x21, 0x23, 0x27, 0x07, 0x0F, 0x08)


@given(
    words=st.lists(st.sampled_from([0x00, 0x02, 0x06, 0x07, 0x0F, 0x80, 0x86]), max_size=30),
    option=st.integers(0, 8),
    state=st.sampled_from(STATES),
)
@settings(max_examples=300, deadline=None)
def test_the_simulated_drive_makes_no_transition_that_cia_402_does_not_have(
    words: list[int], option: int, state: int
) -> None:
    (drive,) = drives(x605A=option)[:1]
    for place, value in enumerate((2, 0x60400010, 0x60710010)):
        drive.objects[0x1600, place] = value
    drive.objects[0x1400, 1] = 0x201
    drive.network, drive.status = 0x05, state
    allowed = set(TRANSITIONS) | ({(0x07, 0x27, 0x0F)} if option >= 5 else set())
    for word in words:
        before = drive.status
        drive.hear(CanFrame(0x201, struct.pack("<Hh", word, 0)))
        after = drive.status
        if before != after:
            assert (before, after, word) in allowed, (hex(before), hex(after), hex(word))


#: (from, to, controlword) of CiA 402: transitions 2 to 12, 15, and 12 at once for a stop that switches off (option 0)
TRANSITIONS = {
    (0x40, 0x21, 0x06), (0x21, 0x23, 0x07), (0x23, 0x27, 0x0F), (0x27, 0x23, 0x07), (0x23, 0x21, 0x06),
    (0x27, 0x21, 0x06), (0x27, 0x07, 0x02), (0x27, 0x40, 0x02), (0x08, 0x40, 0x80), (0x08, 0x40, 0x86),
    *itertools.product((0x21, 0x23, 0x27, 0x07), (0x40,), (0x00,)),
    *itertools.product((0x21, 0x23), (0x40,), (0x02,)),
}  # fmt: skip


def test_the_states_of_the_simulated_drive_are_those_of_the_statusword() -> None:
    assert all(state_of(state | 0x1200) == state for state in STATES)
