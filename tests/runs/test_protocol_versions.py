"""A log keeps the version of the wire that its frames are of, and the versions before this one stay readable."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from firmware_protocol.enumerations import DriveState
from firmware_protocol.errors import BadInputError
from firmware_protocol.protocol_versions import CURRENT, protocol
from gimbal_hil.data.runs.frame_columns import columns_of
from gimbal_hil.data.runs.schema import FRAME_ROW, FrameDirection


def bitwise_crc(octets: bytes, polynomial: int) -> int:
    crc = 0
    for octet in octets:
        crc ^= octet << 4
        for _ in range(8):
            crc = ((crc << 1) ^ (polynomial if crc & 0x800 else 0)) & 0xFFF
    return crc


def first_version_frame(data_id: int, fields: int, counter: int) -> int:
    """A frame as version 1 had it: CRC-12/DECT over data id, bytes 0 to 5, counter."""
    crc = bitwise_crc(bytes([data_id]) + fields.to_bytes(6, "little") + bytes([counter]), 0x80F)
    return fields | counter << 48 | crc << 52


def _rows(*frames: tuple[int, int]) -> np.ndarray:
    rows = np.zeros(len(frames), FRAME_ROW)
    for place, (identifier, payload) in enumerate(frames):
        rows[place]["tick"], rows[place]["identifier"], rows[place]["payload"] = place, identifier, payload
        rows[place]["direction"] = FrameDirection.DEVICE_TO_HOST
    return rows


def test_frames_of_the_first_version_are_read_as_it_meant_them() -> None:
    first = protocol(1, "test")
    attitude = (100 & 0xFFFF) | ((-200 & 0xFFFF) << 16) | ((300 & 0xFFFF) << 32)
    status = int(DriveState.OPERATION_ENABLED) | 77 << 10 | 20 << 20 | 5 << 36
    rows = _rows((0x160, first_version_frame(0x16, attitude, 3)), (0x130, first_version_frame(0x13, status, 4)))
    told = columns_of(rows, "base_attitude", first)
    assert [told.physical(name).tolist() for name in ("roll", "pitch", "yaw")] == [
        [100 * 1e-4],
        [-200 * 1e-4],
        [300 * 1e-4],
    ]
    assert columns_of(rows, "drive_status", first).raw["last_sequence"].tolist() == [77]
    assert len(columns_of(rows, "identity", first).place) == 0
    assert len(columns_of(rows, "drive_status", CURRENT).place) == 0


def test_a_version_that_nobody_knows_is_refused_by_name() -> None:
    with pytest.raises(BadInputError, match=r"run\.yaml: protocol: is 3; expected 1 or 2"):
        protocol(3, "run.yaml: protocol")


def test_torques_count_in_the_units_that_the_identity_told() -> None:
    from firmware_protocol.codec import pack_raw

    unit, motor = CURRENT.by_name["identity_unit"], CURRENT.by_name["motor_status_outer"]
    frames = [
        (message.can_id, int.from_bytes(pack_raw(message, raw, 0), "little"))
        for message, raw in ((unit, (1, 5, 0)), (motor, (1000, 200, 1400, 0, 0)))
    ]
    assert columns_of(_rows(*frames), "motor_status_outer").physical("torque").tolist() == [1000 * 0.125e-3 * 32]
    assert columns_of(_rows(frames[1]), "motor_status_outer").physical("torque").tolist() == [0.125]


def test_run_yaml_says_which_version_and_one_that_does_not_is_of_the_first(tmp_path: Path) -> None:
    from gimbal_hil.data.runs import open_run
    from tests.runs.synthetic import record_run

    folder = tmp_path / "run"
    record_run(folder, 50)
    assert yaml.safe_load((folder / "run.yaml").read_text())["protocol"] == CURRENT.version
    assert open_run(folder).protocol is CURRENT
    document = yaml.safe_load((folder / "run.yaml").read_text())
    del document["protocol"]
    (folder / "run.yaml").write_text(yaml.safe_dump(document))
    assert open_run(folder).protocol.version == 1
