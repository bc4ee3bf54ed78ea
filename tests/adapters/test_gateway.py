"""What a gateway of two drives tells, what it asks them for, and when it calls that a fault: tick by tick."""

from __future__ import annotations

import pytest

from firmware_protocol.adapters import Power
from firmware_protocol.codec import pack, record, schema_of
from firmware_protocol.enumerations import DriveRequest, DriveState, FaultCode, StopReaction
from firmware_protocol.messages import (
    DeadmanConfig,
    DriveStatus,
    FeedbackInner,
    FeedbackOuter,
    Identity,
    IdentityUnit,
    MotorStatusInner,
    MotorStatusOuter,
    SetPoint,
)
from tests.adapters.told import OFF, ON, SILENT, Powers, Shorting, Spoken

NONE, ENABLE, DISABLE = DriveRequest.NONE, DriveRequest.ENABLE_OPERATION, DriveRequest.DISABLE_VOLTAGE
FAULTED = (Power.OFF, Power.FAULT)
#: beyond what a frame can carry
FAR_RAD, FAST_RAD_S = 51.0, 21.0


def in_fault(cause: str) -> Spoken:
    """A gateway whose drives have let go after a fault: one of a drive, of the set-points, or of a position."""
    spoken = Spoken().enabled()
    if cause == "drive":
        spoken.tick(NONE, FAULTED)
    elif cause == "set-points":
        for _ in range(21):
            spoken.tick(ENABLE, ON, is_fed=False)
    else:
        spoken.drives[0].says(Power.ON, position_rad=FAR_RAD)
        spoken.says()
    for _ in range(3):
        spoken.tick(NONE, FAULTED if cause == "drive" else OFF)
    assert spoken.gateway.state is DriveState.FAULT
    return spoken


@pytest.mark.parametrize("is_asked", [False, True])
def test_each_set_has_both_axes_and_now_and_then_who_and_how_warm(is_asked: bool) -> None:
    spoken, at = Spoken(is_asked=is_asked), dict[type, list[int]]()
    for drive in spoken.drives:
        drive.says(Power.OFF, torque_nm=0.5, temperature_degc=30.0, supply_v=24.0)
    for tick in range(1, 2101):
        # a host that asks now and then, and once for the name
        spoken.tick(NONE, OFF, identify=tick == 333)
        for kind in spoken.says():
            at.setdefault(kind, []).append(tick)
    assert at[FeedbackOuter] == at[FeedbackInner] == at[DriveStatus] == list(range(1, 2101))
    assert at[MotorStatusOuter] == at[MotorStatusInner] == list(range(50, 2101, 50))
    assert at[Identity] == at[IdentityUnit] == [1, 333, 1000, 2000]


@pytest.mark.parametrize("is_asked", [False, True])
def test_a_set_names_the_set_point_that_acted_before_its_sample(is_asked: bool) -> None:
    spoken = Spoken(is_asked=is_asked).enabled()
    spoken.tick(ENABLE, ON)
    # the answer to a question was measured before the set-point that came with it could act
    assert spoken.says()[DriveStatus].last_sequence == spoken.count - is_asked


@pytest.mark.parametrize("place", [0, 1])
@pytest.mark.parametrize(
    "beyond",
    [
        {"position_rad": FAR_RAD},
        {"position_rad": -FAR_RAD},
        {"rate_rad_s": FAST_RAD_S},
        {"rate_rad_s": -FAST_RAD_S},
        {"gyro_rad_s": -FAST_RAD_S},
    ],
    ids=str,
)
def test_what_no_frame_can_carry_is_a_fault_that_stops_without_a_sensor(beyond: dict[str, float], place: int) -> None:
    spoken = Spoken(Shorting).enabled()
    for drive in spoken.drives:
        drive.says(Power.ON, position_rad=0.5, rate_rad_s=0.25)
    spoken.says()
    spoken.drives[place].says(Power.ON, **beyond)
    spoken.drives[1 - place].says(Power.ON)
    told = spoken.says()[FeedbackInner if place else FeedbackOuter]
    assert (told.position_rad, told.rate_rad_s) == pytest.approx((0.5, 0.25), abs=1e-5)
    assert spoken.tick(ENABLE) == {b"short", b"fed"}
    assert spoken.gateway.fault is FaultCode.ENCODER
    # a host that wants no torque changes nothing in that
    assert spoken.tick(DISABLE, ON) == {b"short", b"fed"}


def test_the_deadman_counts_down_and_stops_the_drives_by_themselves() -> None:
    spoken = Spoken().enabled()
    for left in range(19, 0, -1):
        assert spoken.tick(ENABLE, ON, is_fed=False) == {b"torque"}
        assert spoken.says()[DriveStatus].deadman_margin_ticks == left
    assert spoken.tick(ENABLE, ON, is_fed=False) == {b"stop", b"fed"}
    assert (spoken.gateway.state, spoken.gateway.fault) == (DriveState.FAULT_REACTION_ACTIVE, FaultCode.DEADMAN)


def test_drives_that_have_not_spoken_yet_are_asked_and_nothing_else() -> None:
    spoken = Spoken()
    for powers in (*[SILENT] * 50, *[(Power.OFF, None)] * 50):
        assert spoken.tick(NONE, powers) == {b"fed"}
    assert spoken.gateway.state is DriveState.SWITCH_ON_DISABLED
    assert spoken.tick(NONE, OFF) == {b"release", b"fed"}


def test_torque_is_given_up_once_both_drives_have_said_so() -> None:
    spoken = Spoken().enabled()
    for powers in (SILENT, (Power.OFF, None), (None, Power.ON), (Power.OFF, Power.ON)):
        assert b"release" in spoken.tick(DISABLE, powers)
        assert spoken.gateway.state is DriveState.OPERATION_ENABLED
    assert spoken.tick(DISABLE, OFF) == {b"fed"}
    assert spoken.gateway.state is DriveState.SWITCH_ON_DISABLED


@pytest.mark.parametrize(("request_", "starts"), [(NONE, False), (DriveRequest.SWITCH_ON, False), (ENABLE, True)])
def test_torque_is_asked_for_only_where_the_host_does_and_after_it_has_switched_on(
    request_: DriveRequest, starts: bool
) -> None:
    assert (b"enable" in Spoken().switched_on().tick(request_, OFF)) is starts
    disabled = Spoken()
    for _ in range(5):
        assert b"enable" not in disabled.tick(request_, OFF)


def test_drives_may_take_their_time_to_come_under_torque() -> None:
    spoken = Spoken().switched_on()
    for powers in (*[OFF] * 50, *[(Power.ON, Power.OFF)] * 50):
        assert spoken.tick(ENABLE, powers) == {b"enable"}
        assert spoken.gateway.state is DriveState.SWITCHED_ON
    assert spoken.tick(ENABLE, ON) == {b"torque"} and spoken.gateway.state is DriveState.OPERATION_ENABLED


def test_a_host_that_thinks_better_of_it_gets_no_torque() -> None:
    spoken = Spoken().switched_on()
    assert spoken.tick(ENABLE, OFF) == {b"enable"}
    assert spoken.tick(DriveRequest.DISABLE_OPERATION, (Power.ON, Power.OFF)) == {b"release", b"fed"}
    for _ in range(5):
        assert spoken.tick(NONE, ON) == {b"release", b"fed"} and spoken.gateway.state is DriveState.SWITCHED_ON


def test_a_quick_stop_is_told_from_its_beginning_to_its_end() -> None:
    spoken = Spoken().enabled()
    for powers in (ON, (Power.STOPPING, Power.ON)):
        assert b"stop" in spoken.tick(ENABLE, powers, quick_stop=True)
        assert spoken.gateway.state is DriveState.OPERATION_ENABLED
    for powers in (*[(Power.STOPPING, Power.STOPPING)] * 50, *[(Power.STOPPING, Power.OFF)] * 50):
        assert spoken.tick(NONE, powers, quick_stop=True) == {b"fed"}
        assert spoken.gateway.state is DriveState.QUICK_STOP_ACTIVE
    assert spoken.tick(NONE, OFF, quick_stop=True) == {b"release", b"fed"}
    assert spoken.gateway.state is DriveState.SWITCH_ON_DISABLED


def test_a_quick_stop_may_become_one_without_a_sensor_and_then_stays_one() -> None:
    spoken, stopping = Spoken(Shorting).enabled(), (Power.STOPPING, Power.STOPPING)
    spoken.tick(NONE, ON, quick_stop=True)
    for _ in range(2):
        assert b"short" not in spoken.tick(NONE, stopping, quick_stop=True)
    assert spoken.tick(NONE, stopping, quick_stop=True, stop=StopReaction.BRAKE) == {b"short", b"fed"}
    for control in ({"quick_stop": True}, {}):
        assert spoken.tick(DISABLE, stopping, **control) == {b"short", b"fed"}


def test_a_stop_that_is_under_way_needs_no_set_points() -> None:
    spoken = Spoken()
    spoken.hears(DeadmanConfig(5, StopReaction.COAST))
    spoken.enabled().tick(NONE, ON, quick_stop=True)
    for _ in range(10):
        assert spoken.tick(NONE, ON, is_fed=False, quick_stop=True) == {b"stop", b"fed"}
    assert (spoken.gateway.state, spoken.gateway.fault) == (DriveState.OPERATION_ENABLED, FaultCode.NONE)


@pytest.mark.parametrize(
    ("request_", "powers", "ticks", "fault"),
    [
        (None, ON, 1001, FaultCode.COMMUNICATION),
        (ENABLE, (Power.ON, Power.OFF), 21, FaultCode.INTERNAL),
        (ENABLE, (Power.REACTING, Power.ON), 1, FaultCode.INTERNAL),
        (ENABLE, (Power.ON, Power.FAULT), 1, FaultCode.INTERNAL),
        # told to let go, they have 20 ticks to say that they do
        (DISABLE, SILENT, 22, FaultCode.COMMUNICATION),
        (DISABLE, (Power.OFF, Power.ON), 22, FaultCode.INTERNAL),
    ],
)
def test_what_goes_on_for_too_long_under_torque_is_a_fault(
    request_: DriveRequest | None, powers: Powers, ticks: int, fault: FaultCode
) -> None:
    spoken = Spoken().enabled()
    for _ in range(ticks):
        assert (spoken.gateway.state, spoken.gateway.fault) == (DriveState.OPERATION_ENABLED, FaultCode.NONE)
        spoken.tick(request_, powers)
    assert (spoken.gateway.state, spoken.gateway.fault) == (DriveState.FAULT_REACTION_ACTIVE, fault)


CODES = {"drive": FaultCode.INTERNAL, "set-points": FaultCode.DEADMAN, "position": FaultCode.ENCODER}


@pytest.mark.parametrize("cause", CODES)
def test_a_fault_stays_whatever_the_host_asks_for(cause: str) -> None:
    spoken = in_fault(cause)
    for request in DriveRequest:
        assert spoken.tick(request) == {b"fed"}
        assert (spoken.gateway.state, spoken.gateway.fault) == (DriveState.FAULT, CODES[cause])


@pytest.mark.parametrize("cause", CODES)
def test_a_drive_that_comes_under_torque_in_a_fault_is_told_to_let_go(cause: str) -> None:
    spoken = in_fault(cause)
    assert spoken.tick(NONE, (Power.ON, None)) == {b"release", b"fed"}
    assert (spoken.gateway.state, spoken.gateway.fault) == (DriveState.FAULT_REACTION_ACTIVE, CODES[cause])
    spoken.tick(NONE, OFF)
    assert spoken.gateway.state is DriveState.FAULT


@pytest.mark.parametrize(("cause", "resets"), [("drive", 2), ("set-points", 1), ("position", 2)])
def test_a_reset_is_handed_on_where_something_is_still_wrong_and_only_then(cause: str, resets: int) -> None:
    spoken = in_fault(cause)
    if resets == 2:
        # the level stands: one edge, one reset
        assert [spoken.tick(NONE, fault_reset=True) for _ in range(2)] == [{b"reset", b"fed"}, {b"fed"}]
        assert spoken.gateway.state is DriveState.FAULT
        for drive in spoken.drives:
            drive.says(Power.OFF, position_rad=0.5)
        spoken.says()
        spoken.tick(NONE)
        assert spoken.gateway.state is DriveState.FAULT
    spoken.tick(NONE, fault_reset=True)
    assert (spoken.gateway.state, spoken.gateway.fault) == (DriveState.SWITCH_ON_DISABLED, FaultCode.NONE)


def test_a_drive_s_own_fault_takes_the_place_of_a_lost_link_and_of_nothing_else() -> None:
    spoken = in_fault("set-points")
    spoken.tick(NONE, FAULTED)
    assert spoken.gateway.fault is FaultCode.INTERNAL
    spoken.drives[0].says(Power.OFF, position_rad=FAR_RAD)
    spoken.drives[1].says(Power.OFF)
    spoken.says()
    spoken.tick(NONE)
    assert spoken.gateway.fault is FaultCode.INTERNAL


def test_a_drive_s_own_stop_after_a_fault_ends_with_a_reset_or_after_a_second() -> None:
    powers = Power.STOPPING, Power.FAULT
    spoken = Spoken().enabled()
    assert spoken.tick(ENABLE, powers) == {b"stop", b"fed"}
    assert b"release" in spoken.tick(ENABLE, powers, fault_reset=True)
    spoken = Spoken().enabled()
    spoken.tick(None, powers)
    assert next(tick for tick in range(1, 2000) if b"release" in spoken.tick(None, powers)) == 1001


def test_a_set_point_counts_once_and_a_broken_one_not_at_all() -> None:
    spoken = Spoken(is_asked=False)

    def left(counter: int, *, is_broken: bool = False, identifier: int | None = None) -> int:
        message = SetPoint(0.0, 0.0, counter, True, True)
        payload = bytearray(pack(message, counter))
        payload[0] ^= is_broken
        can_id = schema_of(message).can_id if identifier is None else identifier
        spoken.gateway.hear(record(can_id, bytes(payload)))
        for drive in spoken.drives:
            drive.says(Power.OFF)
        margin: int = spoken.says()[DriveStatus].deadman_margin_ticks
        return margin

    assert [left(3), left(4, is_broken=True), left(3), left(4), left(5, identifier=0x7F0)] == [20, 19, 18, 20, 19]


@pytest.mark.parametrize("quick_stop", [False, True])
@pytest.mark.parametrize("request_", [None, *DriveRequest])
def test_a_drive_s_own_stop_after_a_fault_goes_on_until_the_host_wants_none(
    request_: DriveRequest | None, quick_stop: bool
) -> None:
    spoken, powers = Spoken().enabled(), (Power.ON, Power.FAULT)
    assert b"stop" in spoken.tick(None, powers)
    # a host that has not yet heard of the fault asks for operation, and one that has may ask for a quick stop
    wants_none = not quick_stop and request_ in (DriveRequest.NONE, DriveRequest.SHUTDOWN, DriveRequest.DISABLE_VOLTAGE)
    sent = spoken.tick(request_, powers, quick_stop=quick_stop)
    assert (b"release" in sent, b"stop" in sent) == (wants_none, not wants_none)
    assert spoken.gateway.state is DriveState.FAULT_REACTION_ACTIVE
