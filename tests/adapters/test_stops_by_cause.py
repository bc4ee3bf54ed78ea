"""How a host asks for a stop is how the drives stop: where a sensor is in doubt, without one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.adapters import CanFrame, Gives, MappedDrive, Power, gives_of
from firmware_protocol.adapters.drive import DriveTiming
from firmware_protocol.adapters.obedience import Obedience, Order
from firmware_protocol.enumerations import StopReaction
from firmware_protocol.links import DriveSection
from gimbal_hil.loop.host import HostState
from tests.adapters.fault_rows import Seen
from tests.adapters.faults import spoilt
from tests.adapters.rig import AdapterRig
from tests.adapters.servo import MAP, mapped_files
from tests.adapters.test_obedience import drives
from tests.adapters.told import Shorting, Told

ZERO_VELOCITY, SHORTED, STOPPED = 12, 15, 0
SWITCH_ON_DISABLED, QUICK_STOP_ACTIVE = 0x40, 0x07


@pytest.fixture
def rigs() -> Iterator[Callable[..., AdapterRig]]:
    made: list[AdapterRig] = []

    def build(drive: str, **more: Any) -> AdapterRig:
        made.append(AdapterRig(drive, **more))
        return made[-1]

    yield build
    for rig in made:
        rig.close()


def jumps(seen: Seen) -> Any:
    """The position is a radian off."""
    return replace(seen.now, position_rad=seen.now.position_rad + 1.0)


def doubted(rig: AdapterRig) -> AdapterRig:
    """In motion, the host no longer believes the first position."""
    rig.connected().position(0.9, -0.9).run(150)
    spoilt(rig, jumps, [rig.gateway.drives[0].sample])
    rig.run(8)
    assert rig.host.state is HostState.FAULT and rig.host.cause.name == "POSITION_JUMP"
    return rig


def test_a_moteus_shorts_its_winding_where_a_sensor_is_in_doubt_and_until_the_host_leads_back(
    rigs: Callable[..., AdapterRig],
) -> None:
    rig = doubted(rigs("moteus"))
    modes = [drive.mode for drive in rig.gimbal.drives]  # type: ignore[attr-defined]
    assert modes == [SHORTED, SHORTED]
    # longer than a stop may take: a shorted winding has no torque of the drive's own, and goes on holding back
    rig.run(6000)
    assert [drive.mode for drive in rig.gimbal.drives] == modes  # type: ignore[attr-defined]
    assert rig.only_brakes()


def test_a_shorted_winding_holds_back_what_would_coast(rigs: Callable[..., AdapterRig]) -> None:
    gone = {}
    for drive in ("moteus", "odrive"):
        rig = doubted(rigs(drive))
        start = float(rig.joints[0])
        rig.run(3000)
        gone[drive] = abs(float(rig.joints[0]) - start)
    assert gone["moteus"] < 0.9 * gone["odrive"]


def test_an_operator_s_stop_is_the_drive_s_own_whose_sensors_nobody_doubts(rigs: Callable[..., AdapterRig]) -> None:
    rig = rigs("moteus").connected().position(0.9, -0.9).run(150)
    rig.host.quick_stop()
    rig.run(5)
    assert {drive.mode for drive in rig.gimbal.drives} == {ZERO_VELOCITY}  # type: ignore[attr-defined]


def test_a_drive_that_cannot_short_lets_go_and_never_stops_by_the_sensor_in_doubt(
    rigs: Callable[..., AdapterRig],
) -> None:
    rig = rigs("cia402", drives=drives(x605A=6)).connected().position(0.9, -0.9).run(150)
    spoilt(rig, jumps, [rig.gateway.drives[0].sample])
    seen = set()
    for _ in range(100):
        rig.run(1)
        seen |= {drive.status for drive in rig.gimbal.drives}  # type: ignore[attr-defined]
    assert rig.host.state is HostState.FAULT and QUICK_STOP_ACTIVE not in seen
    assert {drive.status for drive in rig.gimbal.drives} == {SWITCH_ON_DISABLED}  # type: ignore[attr-defined]
    assert rig.has_no_torque()


@pytest.mark.parametrize(
    ("reaction", "mode"),
    [("coast", STOPPED), ("brake", SHORTED), ("decelerate_and_hold", ZERO_VELOCITY)],
)
def test_set_points_that_stay_away_end_in_the_configured_stop(
    rigs: Callable[..., AdapterRig], reaction: str, mode: int
) -> None:
    rig = rigs("moteus", more={"supervisor": {"deadman": {"window_ticks": 20, "reaction": reaction}}})
    rig.connected().position(0.9, -0.9).run(150)
    rig.host_speaks = False
    rig.run(40)
    assert {drive.mode for drive in rig.gimbal.drives} == {mode}  # type: ignore[attr-defined]


def test_a_drive_of_a_map_is_told_its_word_for_a_short_and_off_without_one(tmp_path: Path) -> None:
    files = mapped_files(tmp_path)
    section = DriveSection(id=1, torque_nm=5.0, map=Path(files["map"]))
    timing = DriveTiming(1e-3, 0.02)
    without = MappedDrive(section, timing)
    assert Gives.SHORT not in without.gives and run_word(without.short()[0]) == MAP["enable"]["off"]
    text = Path(files["map"]).read_text()
    Path(files["map"]).write_text(text.replace("  stop: 3", "  stop: 2\n  short: 3"))
    told = MappedDrive(section, timing)
    assert Gives.SHORT in told.gives and run_word(told.short()[0]) == 3
    assert run_word(told.stop()[0]) == 2
    assert Gives.SHORT in gives_of("moteus", section) and Gives.SHORT not in gives_of("odrive", section)


def run_word(frame: CanFrame) -> int:
    """What a command of the servo's says in `Run`."""
    return frame.data[3] & 3


@given(
    orders=st.lists(st.sampled_from([*StopReaction, "let go", Order.FOLLOW]), min_size=1, max_size=12),
    shorts=st.booleans(),
)
@settings(max_examples=200, deadline=None)
def test_a_stop_without_a_sensor_stands_until_the_host_leads_back(orders: list[Any], shorts: bool) -> None:
    drive = Shorting() if shorts else Told()
    drive.says(Power.ON)
    obedience = Obedience([drive], 1e-3)
    words = {Order.STOP: b"stop", Order.RELEASE: b"release", Order.STOP_BLINDLY: b"short" if shorts else b"release"}
    blind = False
    for order in orders:
        if order is Order.FOLLOW:
            obedience.give(order)
            blind = False
            continue
        obedience.let_go() if order == "let go" else obedience.stop(order)
        blind = blind or order in (StopReaction.BRAKE, StopReaction.GYRO_STOP)
        assert (obedience.order is Order.STOP_BLINDLY) == blind
        drive.says(Power.ON)
        assert not obedience.is_done()
        assert words[obedience.order] in [frame.data for frame in obedience.frames()]
        if blind:
            # torque of the drive's own is not what was asked for
            drive.says(Power.STOPPING)
            assert not obedience.is_done()
            drive.says(Power.OFF)
            assert obedience.is_done()


def test_a_motor_that_its_drive_calls_hot_stops_the_axes(rigs: Callable[..., AdapterRig]) -> None:
    rig = rigs("moteus").connected().position(0.3, -0.3).run(200)
    assert rig.host.state is HostState.ACTIVE
    spoilt(rig, lambda seen: replace(seen.now, temperature_degc=150.0), [rig.gateway.drives[1].sample], 1)
    rig.run(60)
    assert rig.host.state is HostState.FAULT and rig.host.cause.name == "TEMPERATURE", rig.events[-3:]
