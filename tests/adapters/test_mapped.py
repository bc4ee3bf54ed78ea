"""A drive of anybody's by its DBC and a YAML map: signals, units, counter, CRC, enable, and what is refused."""

from __future__ import annotations

import copy
import math
import struct
import tempfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.adapters import CanFrame, DriveTiming, Gives, MappedDrive, Power, load_map, require_drives
from firmware_protocol.documents import yaml_text
from firmware_protocol.errors import BadInputError
from firmware_protocol.links import DriveSection

cantools = pytest.importorskip("cantools", reason="cantools is not installed (the extra test has it)")

DBC = """VERSION ""
NS_ :
BS_:
BU_: HOST SERVO
BO_ 256 Status: 8 SERVO
 SG_ Angle : 0|24@1- (0.001,0) [-8000|8000] "deg" HOST
 SG_ Speed : 24|16@1- (0.1,0) [-3000|3000] "rpm" HOST
 SG_ State : 40|4@1+ (1,0) [0|15] "" HOST
 SG_ Alive : 48|4@1+ (1,0) [0|15] "" HOST
 SG_ Check : 56|8@1+ (1,0) [0|255] "" HOST
BO_ 512 Command: 8 HOST
 SG_ Torque : 0|16@1- (1,0) [-20000|20000] "mN m" SERVO
 SG_ Run : 16|2@1+ (1,0) [0|3] "" SERVO
 SG_ Mode : 24|4@1+ (1,0) [0|15] "" SERVO
 SG_ Alive : 48|4@1+ (1,0) [0|15] "" SERVO
 SG_ Check : 56|8@1+ (1,0) [0|255] "" SERVO
"""
MAP: dict[str, Any] = {
    "schema": 1,
    "dbc": "servo.dbc",
    "id_step": 16,
    "feedback": {
        "position": {"message": "Status", "signal": "Angle", "unit": "deg", "sign": -1},
        "rate": {"message": "Status", "signal": "Speed", "unit": "rpm", "sign": -1},
    },
    "power": {"message": "Status", "signal": "State", "on": [4], "fault": [15]},
    "torque": {"message": "Command", "signal": "Torque", "unit": "mN m", "sign": -1},
    "enable": {"message": "Command", "signal": "Run", "on": 1, "off": 0, "reset": 2},
    "constants": {"Command": {"Mode": 3}},
    "messages": {
        "Status": {"rate_hz": 1000, "counter": {"signal": "Alive"}, "crc": "Check"},
        "Command": {"counter": {"signal": "Alive"}, "crc": "Check"},
    },
}
TIMING = DriveTiming(1e-3, 0.02)


def crc_of_j1850(data: bytes) -> int:
    """CRC-8 of SAE J1850, bit by bit, of these bytes."""
    crc = 0xFF
    for bit in (byte >> place & 1 for byte in data for place in range(7, -1, -1)):
        crc = ((crc << 1) ^ (0x1D if crc >> 7 ^ bit else 0)) & 0xFF
    return crc ^ 0xFF


def written(folder: Path, document: dict[str, Any]) -> Path:
    (folder / "servo.dbc").write_text(DBC)
    (folder / "map.yaml").write_text(yaml_text(document))
    return folder / "map.yaml"


@pytest.fixture
def drive(tmp_path: Path) -> MappedDrive:
    return MappedDrive(DriveSection(id=2, torque_nm=5.0, map=written(tmp_path, MAP)), TIMING)


def status(angle_deg: float, speed_rpm: float, state: int, alive: int, spoil: int = 0) -> CanFrame:
    angle, speed = round(angle_deg * 1000) & 0xFFFFFF, round(speed_rpm * 10) & 0xFFFF
    data = (angle | speed << 24 | state << 40 | alive << 48).to_bytes(7, "little")
    return CanFrame(256 + 32, data + bytes([crc_of_j1850(data) ^ spoil]))


def test_feedback_comes_in_si_units_with_sign_and_the_drive_says_whether_it_has_torque(drive: MappedDrive) -> None:
    assert drive.take(status(-90.0, 60.0, 4, 1))
    assert drive.sample.position_rad == pytest.approx(math.pi / 2)
    assert drive.sample.rate_rad_s == pytest.approx(-2.0 * math.pi)
    assert drive.sample.power is Power.ON and drive.sample.updates == 1
    assert drive.take(status(-90.0, 60.0, 15, 2)) and drive.sample.power is Power.FAULT
    assert drive.gives.isdisjoint({Gives.GYRO, Gives.TORQUE, Gives.DEADMAN_ECHO})


def test_a_bad_crc_a_repeated_counter_and_a_frame_of_another_drive_change_nothing(drive: MappedDrive) -> None:
    assert drive.take(status(10.0, 0.0, 4, 1))
    before = drive.sample
    assert not drive.take(status(20.0, 0.0, 4, 2, spoil=1))
    assert not drive.take(status(20.0, 0.0, 4, 1))
    assert not drive.take(CanFrame(256 + 16, status(20.0, 0.0, 4, 2).data))
    assert not drive.take(CanFrame(256 + 32, b"\x00\x01"))
    assert drive.sample == before and drive.bad_frames == 3


def test_a_command_has_torque_enable_constants_counter_and_crc(drive: MappedDrive) -> None:
    frames = [drive.command(1.25)[0], drive.command(1.25)[0], drive.release()[0], drive.reset()[0]]
    assert all(frame.identifier == 512 + 32 for frame in frames)
    database = cantools.database.load_string(DBC)
    values = [database.decode_message("Command", frame.data) for frame in frames]
    assert [value["Torque"] for value in values] == [-1250, -1250, 0, 0]
    assert [value["Run"] for value in values] == [1, 1, 0, 2]
    assert [value["Alive"] for value in values] == [0, 1, 2, 3]
    assert all(value["Mode"] == 3 for value in values)
    assert all(frame.data[7] == crc_of_j1850(frame.data[:7]) for frame in frames)


def test_a_torque_beyond_the_signal_is_held_at_its_bound(drive: MappedDrive) -> None:
    database = cantools.database.load_string(DBC)
    assert database.decode_message("Command", drive.command(1e6)[0].data)["Torque"] == -20000


def test_a_status_that_stays_away_for_five_of_its_periods_is_a_fault(drive: MappedDrive) -> None:
    drive.take(status(10.0, 0.0, 4, 1))
    for _ in range(5):
        drive.command(0.0)
    assert drive.sample.power is Power.ON
    drive.command(0.0)
    # it said that it is on, and nothing since
    assert drive.sample.power is Power.REACTING and drive.sample.fault == "Status stays away"


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        (("feedback", "position", "signal"), "Winkel", "feedback.position: Status has no signal 'Winkel'"),
        (("feedback", "position", "unit"), "rpm", "feedback.position.unit: 'rpm'; expected rad or deg or turn"),
        (("torque", "message"), "Order", "torque: the DBC has no message 'Order'; expected Status, Command"),
        (("power", "on"), "yes", "power.on"),
        (("enable", "of"), 0, "enable.of: unknown key; expected off?"),
        (("messages", "Status", "crc"), "Sum", "messages.Status: Status has no signal 'Sum'"),
        (("dbc",), "other.dbc", "dbc: "),
    ],
)
def test_what_does_not_fit_the_dbc_is_refused_with_file_and_key(
    tmp_path: Path, path: tuple[str, ...], value: Any, said: str
) -> None:
    document = copy.deepcopy(MAP)
    section = document
    for key in path[:-1]:
        section = section[key]
    section[path[-1]] = value
    file = written(tmp_path, document)
    with pytest.raises(BadInputError) as refused:
        load_map(file)
    assert said in str(refused.value) and str(file) in str(refused.value)


def _drive(folder: Path, dbc: str, mapping: dict[str, Any], torque_nm: float = 9.0) -> MappedDrive:
    (folder / "servo.dbc").write_text(dbc)
    (folder / "map.yaml").write_text(yaml_text(mapping))
    return MappedDrive(DriveSection(id=0, torque_nm=torque_nm, map=folder / "map.yaml"), TIMING)


HEAD = 'VERSION ""\nNS_ :\nBS_:\nBU_: HOST SERVO\n'
FLOATS = (
    HEAD
    + """BO_ 256 Status: 8 SERVO
 SG_ Angle : 0|32@1- (1,0) [0|0] "rad" HOST
 SG_ Speed : 32|32@1- (1,0) [-100|100] "rad/s" HOST
BO_ 257 State: 8 SERVO
 SG_ State : 0|32@1- (1,0) [0|0] "" HOST
BO_ 512 Command: 8 HOST
 SG_ Torque : 0|32@1- (1,0) [0|0] "N m" SERVO
 SG_ Run : 32|2@1+ (1,0) [0|3] "" SERVO
SIG_VALTYPE_ 256 Angle : 1;
SIG_VALTYPE_ 256 Speed : 1;
SIG_VALTYPE_ 257 State : 1;
SIG_VALTYPE_ 512 Torque : 1;
"""
)
FLOAT_MAP: dict[str, Any] = {
    "schema": 1,
    "dbc": "servo.dbc",
    "feedback": {
        "position": {"message": "Status", "signal": "Angle", "unit": "rad", "invalid": [-1.0]},
        "rate": {"message": "Status", "signal": "Speed", "unit": "rad/s"},
    },
    "power": {"message": "State", "signal": "State", "on": [4], "fault": [15]},
    "torque": {"message": "Command", "signal": "Torque", "unit": "N m"},
    "enable": {"message": "Command", "signal": "Run"},
}


def _status(angle: float, speed: float = 0.0) -> CanFrame:
    return CanFrame(256, struct.pack("<ff", angle, speed))


@pytest.mark.parametrize(
    "frame", [_status(math.nan), _status(math.inf), _status(-1.0), _status(0.5, 101.0), _status(0.5, math.nan)]
)
def test_a_value_that_is_none_is_a_fault_until_a_good_one_comes(tmp_path: Path, frame: CanFrame) -> None:
    drive = _drive(tmp_path, FLOATS, FLOAT_MAP)
    on = CanFrame(257, struct.pack("<f", 4.0) + bytes(4))
    assert drive.take(on) and drive.take(_status(0.5)) and drive.sample.power is Power.ON
    assert drive.take(frame)
    assert drive.sample.power is Power.REACTING and drive.sample.position_rad == 0.5
    # the drive saying that it is on makes no value good
    assert drive.take(on) and drive.sample.power is Power.REACTING and "has no valid value" in drive.sample.fault
    assert drive.take(_status(0.6)) and drive.sample.power is Power.ON


@pytest.mark.parametrize("state", [math.nan, math.inf, 4.5])
def test_a_state_that_is_no_number_is_a_fault(tmp_path: Path, state: float) -> None:
    drive = _drive(tmp_path, FLOATS, FLOAT_MAP)
    assert drive.take(CanFrame(257, struct.pack("<f", state) + bytes(4)))
    assert drive.sample.power is Power.REACTING and drive.sample.fault.startswith("State.State = ")


def test_a_float_without_its_value_type_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match=r"one count of Status.Angle is 1 rad.*SIG_VALTYPE_"):
        _drive(tmp_path, FLOATS.replace("SIG_VALTYPE_ 256 Angle : 1;\n", ""), FLOAT_MAP)


def test_words_of_the_value_table_that_say_none_are_a_fault(tmp_path: Path) -> None:
    dbc = DBC + 'VAL_ 256 Angle 8388607 "SNA" 8388606 "Sensor error";\n'
    mapping = MAP | {"messages": {}, "constants": {}}
    drive = _drive(tmp_path, dbc.replace("[-8000|8000]", "[0|0]"), mapping)
    for raw, power in ((1000, Power.ON), (8388607, Power.REACTING), (1000, Power.ON)):
        frame = CanFrame(256, raw.to_bytes(3, "little") + bytes([0, 0, 4, 0, 0]))
        assert drive.take(frame) and drive.sample.power is power


def test_a_single_turn_encoder_goes_on_past_its_zero(tmp_path: Path) -> None:
    mapping = MAP | {"messages": {}, "constants": {}}
    position = MAP["feedback"]["position"] | {"wrap": 360.0, "sign": 1}
    drive = _drive(tmp_path, DBC, mapping | {"feedback": {"position": position}})
    told = []
    for degrees in (350.0, 359.0, 8.0, 20.0, 5.0, 355.0):
        raw = round(degrees / 0.001).to_bytes(3, "little")
        assert drive.take(CanFrame(256, raw + bytes([0, 0, 4, 0, 0])))
        told.append(math.degrees(drive.sample.position_rad))
    assert told == pytest.approx([350.0, 359.0, 368.0, 380.0, 365.0, 355.0])


def test_a_single_turn_encoder_begins_at_its_first_good_value(tmp_path: Path) -> None:
    mapping = MAP | {"messages": {}, "constants": {}}
    position = MAP["feedback"]["position"] | {"wrap": 360.0, "sign": 1}
    drive = _drive(tmp_path, DBC, mapping | {"feedback": {"position": position}})
    # beyond the stated range: it has no value yet, and no turn to go on from
    for degrees in (8388.607, 270.0, 280.0):
        raw = round(degrees / 0.001).to_bytes(3, "little")
        assert drive.take(CanFrame(256, raw + bytes([0, 0, 4, 0, 0])))
    assert math.degrees(drive.sample.position_rad) == pytest.approx(280.0)


_CHECK = 'SG_ Check : 56|8@1+ (1,0) [0|255] "" SERVO'


@pytest.mark.parametrize(
    ("path", "value", "change", "said"),
    [
        # a word that is to take the torque away asks for it
        (("enable", "off"), 1, (), r"enable.off: 1 is the word for on"),
        (("enable", "stop"), 1, (), r"enable.stop: 1 is the word for on"),
        (("enable", "short"), 1, (), r"enable.short: 1 is the word for on"),
        (("enable", "reset"), 1, (), r"enable.reset: 1 is the word for on"),
        (("power", "fault"), [4], (), r"power.fault: 4 is on already"),
        (("power", "stopping"), [15], (), r"power.fault: 15 is stopping already"),
        (("power", "on"), [], (), r"power.on: is empty"),
        (("power", "on"), [99], (), r"power.on: 99 is never said; expected 0 to 15"),
        # a counter or a CRC in the place of the torque would be torque
        (("messages", "Command", "counter"), {"signal": "Torque"}, (), r"Command.Torque is that of torque already"),
        (("messages", "Command", "crc"), "Torque", (), r"Command.Torque is that of torque already"),
        (("constants", "Command"), {"Torque": 500.0}, (), r"Command.Torque is that of torque already"),
        (("constants", "Command"), {"Run": 1.0}, (), r"Command.Run is that of enable already"),
        (("feedback", "rate", "scale"), 0.0, (), r"Status.Speed always says the same"),
        (("feedback", "position", "wrap"), 5e-324, (), r"position.wrap: .* a span of at least 0.5 rad"),
        (("feedback", "position", "wrap"), 1.0, (), r"position.wrap: 1 deg; expected a span of at least 0.5 rad"),
        ((), None, (_CHECK, _CHECK.replace("56|8", "56|4")), r"messages.Command.crc: .* no whole byte"),
        ((), None, (_CHECK, _CHECK.replace("56|8", "54|8")), r"messages.Command.crc: .* no whole byte"),
        ((), None, (_CHECK, _CHECK.replace("8@1+", "8@1-")), r"messages.Command.crc: .* no whole byte"),
        ((), None, (_CHECK, _CHECK.replace("(1,0)", "(2,0)")), r"messages.Command.crc: .* no whole byte"),
        ((), None, ("SG_ Mode : 24|4@1+ (1,0)", "SG_ Mode : 24|4@1+ (0,3)"), r"dbc: Command cannot be written"),
        ((), None, ("0|24@1- (0.001,0)", "0|24@1- (0,0)"), r"Status.Angle always says the same"),
        ((), None, ("BO_ 512 Command: 8", "BO_ 512 Command: 12"), r"Command has 12 bytes; expected 8 at most"),
    ],
)
def test_a_map_in_which_one_thing_means_two_is_refused(
    tmp_path: Path, path: tuple[str, ...], value: Any, change: tuple[str, ...], said: str
) -> None:
    mapping = copy.deepcopy(MAP)
    section = mapping
    for key in path[:-1]:
        section = section[key]
    if path:
        section[path[-1]] = value
    else:
        assert change[0] in DBC
    with pytest.raises(BadInputError, match=said):
        _drive(tmp_path, DBC.replace(*change) if change else DBC, mapping)


def test_an_identifier_that_no_frame_can_have_is_refused(tmp_path: Path) -> None:
    written(tmp_path, MAP | {"id_step": 2000})
    sections = [DriveSection(id=k, torque_nm=9.0, map=tmp_path / "map.yaml") for k in (0, 1)]
    with pytest.raises(BadInputError, match=r"id_step: .* would have the identifier 0x8D0; expected one up to 0x7FF"):
        require_drives("dbc", sections)


MULTIPLEXED = (
    HEAD
    + """BO_ 256 Status: 8 SERVO
 SG_ Sel M : 0|8@1+ (1,0) [0|0] "" HOST
 SG_ Angle m0 : 8|24@1- (0.001,0) [0|0] "deg" HOST
 SG_ State m1 : 16|4@1+ (1,0) [0|15] "" HOST
 SG_ Check : 56|8@1+ (1,0) [0|255] "" HOST
BO_ 512 Command: 8 HOST
 SG_ Torque : 0|16@1- (1,0) [0|0] "mN m" SERVO
 SG_ Run : 16|2@1+ (1,0) [0|3] "" SERVO
"""
)


@given(data=st.binary(max_size=8))
@settings(max_examples=300, deadline=None)
def test_no_frame_ends_in_a_traceback(data: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        for dbc, mapping in ((MULTIPLEXED, _multiplexed()), (FLOATS, FLOAT_MAP)):
            drive = _drive(Path(folder), dbc, mapping)
            for identifier in (256, 257):
                drive.take(CanFrame(identifier, data))
            assert math.isfinite(drive.sample.position_rad)


def _multiplexed() -> dict[str, Any]:
    return {
        "schema": 1,
        "dbc": "servo.dbc",
        "feedback": {"position": {"message": "Status", "signal": "Angle", "unit": "deg"}},
        "power": {"message": "Status", "signal": "State", "on": [4], "fault": [15]},
        "torque": {"message": "Command", "signal": "Torque", "unit": "mN m"},
        "enable": {"message": "Command", "signal": "Run"},
    }


def test_behind_a_selector_each_frame_tells_what_it_carries(tmp_path: Path) -> None:
    drive = _drive(tmp_path, MULTIPLEXED, _multiplexed())
    assert drive.take(CanFrame(256, bytes([0]) + (12000).to_bytes(3, "little") + bytes(4)))
    assert (drive.sample.updates, drive.sample.power) == (1, Power.OFF)
    assert drive.take(CanFrame(256, bytes([1, 0, 4]) + bytes(5)))
    assert (drive.sample.updates, drive.sample.power) == (1, Power.ON)
    assert drive.sample.position_rad == pytest.approx(math.radians(12.0))
    # a selector that the DBC does not know
    assert not drive.take(CanFrame(256, bytes([7]) + bytes(7))) and drive.bad_frames == 1


@pytest.mark.parametrize(("torque", "raw"), [(33.0, 32767), (-40.0, -32768), (9.0, 9000)])
def test_a_torque_is_held_at_what_the_bits_carry(tmp_path: Path, torque: float, raw: int) -> None:
    drive = _drive(tmp_path, MULTIPLEXED, _multiplexed(), torque_nm=40.0)
    assert int.from_bytes(drive.command(torque)[0].data[:2], "little", signed=True) == raw


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ((" SG_ Torque : 0|16@1-", " SG_ Torque : 0|16@1+"), "carries 0 to 65.535 N m"),
        ((" SG_ Torque : 0|16@1-", " SG_ Torque : 0|13@1-"), "carries -4.096 to 4.095 N m"),
    ],
)
def test_two_drives_of_which_one_cannot_carry_its_torque_are_refused(
    tmp_path: Path, change: tuple[str, str], said: str
) -> None:
    _drive(tmp_path, MULTIPLEXED.replace(*change), _multiplexed() | {"id_step": 16})
    sections = [DriveSection(id=k, torque_nm=9.0, map=tmp_path / "map.yaml") for k in (0, 1)]
    with pytest.raises(BadInputError, match=said):
        require_drives("dbc", sections)


def test_two_drives_on_one_identifier_are_refused(tmp_path: Path) -> None:
    _drive(tmp_path, MULTIPLEXED, _multiplexed())
    sections = [DriveSection(id=k, torque_nm=9.0, map=tmp_path / "map.yaml") for k in (0, 1)]
    with pytest.raises(BadInputError, match=r"both drives use the identifier 0x100"):
        require_drives("dbc", sections)
    with pytest.raises(BadInputError, match=r"both drives have the id 3"):
        require_drives("moteus", [DriveSection(id=3, torque_nm=1.0)] * 2)


@pytest.mark.parametrize(
    ("dbc", "mapping", "said"),
    [
        (
            MULTIPLEXED,
            {"enable": {"message": "Command", "signal": "Run", "on": 4}},
            r"enable.on: 4 does not fit Command.Run",
        ),
        (MULTIPLEXED.replace('(1,0) [0|0] "mN m"', '(1,0) [-20|-1] "mN m"'), {}, "cannot carry zero"),
        (
            MULTIPLEXED,
            {"feedback": {"position": {"message": "Status", "signal": "Angle", "unit": "rad"}}},
            r"feedback.position.unit: 'rad', but the DBC says 'deg'",
        ),
    ],
)
def test_what_cannot_be_sent_or_meant_is_refused(tmp_path: Path, dbc: str, mapping: dict[str, Any], said: str) -> None:
    with pytest.raises(BadInputError, match=said):
        _drive(tmp_path, dbc, _multiplexed() | mapping)


def test_a_rate_that_a_drive_does_not_tell_is_that_of_its_position(tmp_path: Path) -> None:
    drive = _drive(tmp_path, MULTIPLEXED, _multiplexed())
    assert Gives.RATE not in drive.gives
    for k in range(60):
        drive.command(0.0)
        drive.take(CanFrame(256, bytes([0]) + (100 * k).to_bytes(3, "little") + bytes(4)))
    assert drive.sample.rate_rad_s == pytest.approx(math.radians(0.1) / TIMING.period_s, rel=1e-3)
