"""A drive of anybody's by its DBC and a YAML map: signals, units, counter, CRC, enable, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from firmware_protocol.adapters import CanFrame, DriveTiming, Gives, MappedDrive, Power, load_map
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
    assert drive.sample.power is Power.FAULT


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
    import copy

    document = copy.deepcopy(MAP)
    section = document
    for key in path[:-1]:
        section = section[key]
    section[path[-1]] = value
    file = written(tmp_path, document)
    with pytest.raises(BadInputError) as refused:
        load_map(file)
    assert said in str(refused.value) and str(file) in str(refused.value)
