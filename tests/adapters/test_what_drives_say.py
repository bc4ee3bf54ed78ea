"""What the frames of a drive make of its sample, frame by frame: its numbers, its power, its own word for its fault."""

from __future__ import annotations

import copy
import math
import struct
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from firmware_protocol.adapters import CanFrame, Cia402Drive, MoteusDrive, OdriveDrive, Power
from firmware_protocol.adapters.drive import ForeignDrive, farewell
from firmware_protocol.adapters.moteus import replies
from tests.adapters.test_drives import SECTION, TIMING
from tests.adapters.test_mapped import DBC, MAP, MULTIPLEXED, _drive, _multiplexed

# CiA 402, node 5


def status(word: int, counts: int = 0) -> CanFrame:
    return CanFrame(0x185, struct.pack("<Hi", word, counts))


def emergency(code: int) -> CanFrame:
    return CanFrame(0x85, struct.pack("<HB5x", code, 0x20))


def answer(command: int, index: int, value: int = 0, sub: int = 0) -> CanFrame:
    return CanFrame(0x585, struct.pack("<BHBI", command, index, sub, value))


MOTION = CanFrame(0x285, struct.pack("<ih", 512, 250))
READ, WROTE, REFUSED = 0x43, 0x60, 0x80


def set_up(refuses: int = 0, writes: int = 99) -> Cia402Drive:
    """A node that took so many objects, or all, and refused this one."""
    drive = Cia402Drive(SECTION, TIMING)
    (frame,) = drive.begin()
    for _ in range(writes):
        if frame.identifier != 0x605:
            break
        _, index, sub, _ = struct.unpack("<BHBI", frame.data)
        drive.take(answer(REFUSED if index == refuses else WROTE, index, 0, sub))
        frame = drive.ask()[0]
        if index == refuses != 0x1016:
            break
    return drive


def asked(frames: Sequence[CanFrame]) -> list[bytes]:
    """What is asked of, or written to, node 5's objects, and what its network state is to be."""
    return [frame.data for frame in frames if frame.identifier in (0x605, 0x000)]


def test_a_cia402_drive_that_stops_by_itself_is_told_to_go_on_with_that() -> None:
    drive = set_up()
    for word, told in ((0x27, 0x0F), (0x07, 0x02), (0x27, 0x0F)):
        drive.take(status(word))
        assert struct.unpack_from("<H", drive.command(0.5)[0].data) == (told,)


def test_only_a_node_that_does_not_watch_is_halted_and_now_and_then_again() -> None:
    for watches in (True, False):
        drive = set_up(refuses=0 if watches else 0x1016)
        assert drive.sample.caution.startswith("does not watch this side (object 0x1016 refused") is not watches
        for _ in range(2):
            halts = [call for call in range(1, 102) if bytes([2, 5]) in asked(drive.starve())]
            assert halts == ([] if watches else [1, 51, 101])
            drive.ask()


@pytest.mark.parametrize(
    "frame", [status(0x27, 99), MOTION, emergency(0x7305), answer(REFUSED, 0x1016, 1, 1), CanFrame(0x705, b"\x00")]
)
def test_a_frame_of_another_form_is_not_understood(frame: CanFrame) -> None:
    drive = set_up(writes=0)
    for other in (replace(frame, extended=True), replace(frame, data=frame.data[:-1])):
        before = drive.sample
        # a heartbeat without its byte is one all the same
        assert drive.take(other) is (frame.identifier == 0x705 and not other.extended)
        assert drive.sample == before and not asked(drive.ask())
    # another PDO of this node
    assert not drive.take(CanFrame(0x385, bytes(8)))
    assert drive.take(frame)


def test_a_heartbeat_sets_a_node_up_only_where_it_has_just_started() -> None:
    drive = set_up()
    drive.take(status(0x40))
    assert drive.take(CanFrame(0x705, bytes([5]))) and not asked(drive.ask())
    assert drive.sample.power is Power.OFF
    assert drive.take(CanFrame(0x705, bytes([0]))) and len(asked(drive.ask())) == 1
    assert (drive.sample.power, drive.sample.fault) == (Power.FAULT, "started anew")


def test_an_emergency_is_told_before_the_statusword_and_until_it_has_passed() -> None:
    drive = set_up()
    drive.take(emergency(0x7305))
    assert drive.sample.fault == "error 0x7305, register 0x20"
    drive.take(status(0x08))
    assert drive.sample.fault == "error 0x7305, register 0x20"
    drive.take(emergency(0))
    assert drive.sample.fault == ""


def test_the_torque_of_a_node_that_refused_its_set_up_is_not_this_side_s() -> None:
    drive = set_up(refuses=0x6060)
    for word, power in ((0x40, Power.FAULT), (0x27, Power.REACTING), (0x07, Power.REACTING), (0x21, Power.FAULT)):
        drive.take(status(word))
        assert drive.sample.power is power and drive.sample.fault.startswith("object 0x6060 refused")
    # and nothing starts it
    assert not asked([frame for _ in range(120) for frame in drive.ask()])


def test_a_node_whose_emergency_was_lost_is_asked_for_its_error_once() -> None:
    drive, question = set_up(), struct.pack("<BHBI", 0x40, 0x603F, 0, 0)
    for word, questions in ((0x27, []), (0x08, [question]), (0x08, []), (0x40, []), (0x08, [question])):
        drive.take(status(word))
        assert asked(drive.ask()) == questions
    assert drive.sample.fault == "statusword 0x0008"
    drive.take(answer(READ, 0x603F, 0x2310))
    drive.take(status(0x08))
    assert drive.sample.fault == "error 0x2310"
    known = set_up()
    known.take(emergency(0x7305))
    known.take(status(0x08))
    assert not asked(known.ask())


@pytest.mark.parametrize(
    "frame",
    [
        answer(READ, 0x603F, 0),  # no error
        answer(REFUSED, 0x603F, 0x0602_0000),  # no such object
        answer(READ, 0x1000, 0x20192),  # another object's value
        answer(0x41, 0x1008, 9),  # more than four bytes
        answer(WROTE, 0x6060),  # nothing was written
    ],
)
def test_an_answer_that_tells_of_no_error_makes_none(frame: CanFrame) -> None:
    drive = set_up()
    assert drive.take(frame)
    drive.take(status(0x08))
    assert drive.sample.fault == "statusword 0x0008"


def test_only_the_answer_to_the_last_object_leads_to_the_next() -> None:
    drive = set_up(writes=1)
    # this one was answered already
    drive.take(answer(WROTE, 0x1016, 0, 1))
    assert not asked(drive.ask())
    drive.take(answer(WROTE, 0x1400, 0, 1))
    assert len(asked(drive.ask())) == 1


@pytest.mark.parametrize(
    ("writes", "again"), [(3, struct.pack("<BHBI", 0x23, 0x1016, 1, 127 << 16 | 20)), (99, b"\1\5")]
)
def test_a_node_that_has_fallen_silent_is_set_up_or_started_again(writes: int, again: bytes) -> None:
    drive = set_up(writes=writes)
    said = [asked(drive.ask()) for _ in range(120)]
    places = [place for place, one in enumerate(said) if one]
    assert all(said[place] == [again] for place in places)
    assert len(places) == 2 and places[1] - places[0] == 50
    drive.take(status(0x40))
    assert not any(asked(drive.ask()) for _ in range(49)) and asked(drive.ask())


# ODrive, node 5


def odrive_frame(command: int, *values: float) -> CanFrame:
    return CanFrame(5 << 5 | command, struct.pack("<ff", *values))


def heartbeat(state: int, error: int = 0) -> CanFrame:
    return CanFrame(5 << 5 | 0x01, struct.pack("<IB3x", error, state))


def test_an_odrive_is_asked_for_its_state_at_first_and_then_as_its_heartbeat_can_tell() -> None:
    drive = OdriveDrive(SECTION, TIMING)
    for _ in range(2):
        sent = [[frame.identifier & 0x1F for frame in drive.enable()] for _ in range(102)]
        assert [place for place, commands in enumerate(sent) if commands == [0x0B, 0x0E, 0x07]] == [0, 50, 100]
        assert sum(commands == [0x0E] for commands in sent) == 99
        drive.release()


@pytest.mark.parametrize(
    "frame", [heartbeat(8), *(odrive_frame(command, 0.5, 2.0) for command in (0x09, 0x1C, 0x15, 0x17))]
)
def test_an_odrive_s_frame_of_another_form_changes_nothing(frame: CanFrame) -> None:
    drive = OdriveDrive(SECTION, TIMING)
    short = 4 if frame.identifier & 0x1F == 0x01 else 7
    others = (
        replace(frame, extended=True),
        replace(frame, identifier=frame.identifier + 32),
        replace(frame, data=frame.data[:short]),
        # a command that this side has no use for
        replace(frame, identifier=5 << 5 | 0x03),
    )
    before = drive.sample
    assert not any(drive.take(one) for one in others) and drive.sample == before
    assert drive.take(frame) and drive.sample != before


def test_an_odrive_tells_torque_temperature_and_supply() -> None:
    drive = OdriveDrive(SECTION, TIMING)
    for command, values in ((0x1C, (0.5, 0.75)), (0x15, (40.0, 50.0)), (0x17, (24.0, 3.0))):
        assert drive.take(odrive_frame(command, *values))
    sample = drive.sample
    assert (sample.torque_nm, sample.temperature_degc, sample.supply_v) == (0.75, 50.0, 24.0)
    assert (sample.updates, sample.words) == (0, 0)


@pytest.mark.parametrize("command", [0x09, 0x1C, 0x15, 0x17])
@pytest.mark.parametrize("values", [(math.nan, 2.0), (0.5, math.nan), (0.5, math.inf)])
@pytest.mark.parametrize(("state", "sound", "unsound"), [(8, Power.ON, Power.REACTING), (1, Power.OFF, Power.FAULT)])
def test_an_odrive_s_number_that_is_none_is_a_fault_until_a_good_estimate(
    state: int, sound: Power, unsound: Power, values: tuple[float, float], command: int
) -> None:
    drive = OdriveDrive(SECTION, TIMING)
    for frame in (heartbeat(state), odrive_frame(0x09, 0.5, 2.0)):
        drive.take(frame)
    before = drive.sample
    assert before.power is sound and before.words == 1
    drive.take(odrive_frame(command, *values))
    said = f"ODrive message 0x{command:02X} holds no number"
    assert drive.sample == replace(before, power=unsound, fault=said)
    drive.take(odrive_frame(0x09, 0.5, 2.0))
    assert drive.sample == replace(before, updates=2)


# moteus, id 5


def moteus_reply(mode: int, *numbers: float) -> CanFrame:
    return CanFrame(0x0500, bytes([0x21, 0x00, mode, 0x2F, 0x01]) + struct.pack("<3f", *numbers), True, True)


@pytest.mark.parametrize("data", [bytes([0x21, 0x00, 10]), bytes([0x2D, 0x01]) + struct.pack("<f", 0.25), b"", b"\x21"])
def test_a_moteus_reply_without_mode_or_position_says_nothing(data: bytes) -> None:
    drive = MoteusDrive(SECTION, TIMING)
    assert not drive.take(CanFrame(0x0500, data, True, True)) and drive.sample.updates == 0


@pytest.mark.parametrize("place", range(3))
@pytest.mark.parametrize(("mode", "power"), [(10, Power.REACTING), (12, Power.REACTING), (0, Power.FAULT)])
def test_a_moteus_number_that_is_none_is_a_fault_and_not_a_position(mode: int, power: Power, place: int) -> None:
    drive = MoteusDrive(SECTION, TIMING)
    drive.take(moteus_reply(mode, 0.25, 1.0, 0.5))
    assert drive.sample.power is not power
    drive.take(moteus_reply(mode, *(math.nan if place == at else 0.75 for at in range(3))))
    sample = drive.sample
    assert sample.power is power and sample.position_rad == pytest.approx(math.pi / 2)
    assert (sample.rate_rad_s, sample.torque_nm) == (0.0, 0.0) and sample.fault == "moteus fault 0"


def test_a_moteus_that_has_waited_in_vain_says_so() -> None:
    drive = MoteusDrive(SECTION, TIMING)
    drive.take(moteus_reply(11, 0.25, 0.0, 0.0))
    assert drive.sample.power is Power.REACTING
    assert drive.sample.fault == "moteus: no command in its watchdog's time"


@pytest.mark.parametrize(
    ("data", "found"),
    [
        ([0x20, 3, 0x00, 10, 1, 2], {0: 10.0, 1: 1.0, 2: 2.0}),
        ([0x50, 0x21, 0x00, 10, 0x50], {0: 10.0}),
        ([0x25, 0x01, 0x00, 0x01], {1: 256.0}),
        ([0x20], None),
        ([0x20, 3], None),
        ([0x21], None),
        ([0x21, 0x00], None),
        # no reply
        ([0x41, 0x00, 10], None),
    ],
)
def test_replies_of_a_moteus_are_read_as_its_reference_says(data: list[int], found: dict[int, float] | None) -> None:
    assert replies(bytes(data)) == found


# a drive of a map

OTHER = """BO_ 258 Other: 8 SERVO
 SG_ Angle : 0|24@1- (0.001,0) [-8000|8000] "deg" HOST
 SG_ State : 40|4@1+ (1,0) [0|15] "" HOST
 SG_ Speed : 24|16@1- (0.1,0) [-3000|3000] "rpm" HOST
 SG_ Heat : 48|8@1+ (1,0) [0|200] "degC" HOST
"""
WITH_OTHER = DBC.replace("BO_ 512", f"{OTHER}BO_ 512")


def mapping(**changes: Any) -> dict[str, Any]:
    return copy.deepcopy(MAP) | {"messages": {}, "constants": {}} | changes


def told(message: int, angle_deg: float, state: int, speed_rpm: float = 0.0, heat: int = 0) -> CanFrame:
    word = round(angle_deg * 1000) & 0xFFFFFF | (round(speed_rpm * 10) & 0xFFFF) << 24 | state << 40 | heat << 48
    return CanFrame(message, word.to_bytes(8, "little"))


def test_a_mapped_frame_of_the_other_length_of_identifier_is_another_s(tmp_path: Path) -> None:
    drive = _drive(tmp_path, DBC, mapping())
    frame = told(256, 10.0, 4)
    assert not drive.take(replace(frame, extended=True)) and drive.take(frame)


def test_signals_of_one_name_in_another_message_are_others(tmp_path: Path) -> None:
    drive = _drive(tmp_path, WITH_OTHER, mapping())
    assert drive.take(told(256, -10.0, 4))
    before = drive.sample
    assert drive.take(told(258, 99.0, 15, 60.0)) and drive.sample == before
    assert (before.updates, before.words, before.power) == (1, 1, Power.ON)


def test_a_rate_in_another_message_does_not_make_a_turn_be_counted_anew(tmp_path: Path) -> None:
    feedback = {
        "position": {"message": "Status", "signal": "Angle", "unit": "deg", "wrap": 360.0},
        "rate": {"message": "Other", "signal": "Speed", "unit": "rpm"},
        "temperature": {"message": "Other", "signal": "Heat", "unit": "degC"},
    }
    drive = _drive(tmp_path, WITH_OTHER, mapping(feedback=feedback))
    seen = []
    for angle, speed in ((350.0, 30.0), (359.0, 60.0), (8.0, 60.0)):
        drive.take(told(258, 0.0, 0, speed, 40))
        drive.take(told(256, angle, 4))
        drive.take(told(258, 0.0, 0, speed, 40))
        # the rate is the one that was told, and none of a position's
        seen.append((math.degrees(drive.sample.position_rad), drive.sample.rate_rad_s))
        drive.take(told(256, angle, 4))
        seen.append((math.degrees(drive.sample.position_rad), drive.sample.rate_rad_s))
    wanted = [(350.0, math.pi), (359.0, 2.0 * math.pi), (368.0, 2.0 * math.pi)]
    assert [number for pair in seen for number in pair] == pytest.approx([n for pair in wanted for n in pair * 2])
    assert drive.sample.temperature_degc == 40.0


def test_a_rate_made_of_the_position_is_not_one_of_the_temperature(tmp_path: Path) -> None:
    feedback = {
        "position": {"message": "Status", "signal": "Angle", "unit": "deg"},
        "temperature": {"message": "Other", "signal": "Heat", "unit": "degC"},
    }
    drive = _drive(tmp_path, WITH_OTHER, mapping(feedback=feedback))
    for _ in range(5):
        drive.command(0.0)
        drive.take(told(256, 10.0, 4))
        drive.take(told(258, 0.0, 0, heat=40))
    assert drive.sample.rate_rad_s == 0.0 and drive.sample.temperature_degc == 40.0


@pytest.mark.parametrize(
    ("state", "power", "fault"),
    [
        (15, Power.FAULT, "Status.State = 15 (Overcurrent)"),
        (14, Power.FAULT, "Status.State = 14"),
        (5, Power.STOPPING, ""),
        (4, Power.ON, ""),
        (0, Power.OFF, ""),
    ],
)
def test_a_mapped_drive_s_state_is_told_with_its_name_where_it_has_one(
    tmp_path: Path, state: int, power: Power, fault: str
) -> None:
    words = MAP["power"] | {"stopping": [5], "fault": [14, 15]}
    drive = _drive(tmp_path, DBC + 'VAL_ 256 State 15 "Overcurrent" ;\n', mapping(power=words))
    drive.take(told(256, 10.0, state))
    assert (drive.sample.power, drive.sample.fault) == (power, fault)
    unnamed = _drive(tmp_path, DBC, mapping(power=words))
    unnamed.take(told(256, 10.0, state))
    assert unnamed.sample.fault == fault.removesuffix(" (Overcurrent)")


@pytest.mark.parametrize("guard", [{"crc": "Check"}, {"counter": {"signal": "Check"}}], ids=str)
def test_a_frame_whose_selector_leaves_its_guard_out_is_a_bad_one(tmp_path: Path, guard: dict[str, Any]) -> None:
    dbc = MULTIPLEXED.replace("SG_ Check :", "SG_ Check m0 :")
    drive = _drive(tmp_path, dbc, _multiplexed() | {"messages": {"Status": guard}})
    assert not drive.take(CanFrame(256, bytes([1, 0, 4]) + bytes(5)))
    assert drive.bad_frames == 1 and drive.sample.power is Power.OFF


def test_a_message_without_a_stated_rate_may_stay_away(tmp_path: Path) -> None:
    drive = _drive(tmp_path, DBC, mapping(messages={"Status": {"counter": {"signal": "Alive"}}}))
    drive.take(told(256, 10.0, 4))
    for _ in range(100):
        drive.command(0.0)
    assert drive.sample.power is Power.ON


class Silent:
    """One that can only be let go, and not be left."""

    sample = set_up().sample


def test_a_drive_that_knows_no_farewell_gets_none() -> None:
    drive: Any = Silent()
    assert farewell(drive) == []
    kinds: tuple[Callable[..., ForeignDrive], ...] = (MoteusDrive, OdriveDrive)
    assert [farewell(kind(SECTION, TIMING)) for kind in kinds] == [[], []]
