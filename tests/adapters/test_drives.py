"""Frames of the adapters against the public descriptions of those protocols, byte by byte."""

from __future__ import annotations

import math
import struct
from typing import Any

import pytest

from firmware_protocol.adapters import (
    GROUP,
    CanFrame,
    Cia402Drive,
    DriveTiming,
    Gives,
    MoteusDrive,
    OdriveDrive,
    Power,
    drive_named,
    missing_text,
    on_the_joint,
    require_drives,
)
from firmware_protocol.adapters.cia402 import state_of
from firmware_protocol.adapters.drive import AxisSample, farewell, shaft_torque
from firmware_protocol.adapters.gateway import torque_exponent
from firmware_protocol.adapters.moteus import replies
from firmware_protocol.errors import BadInputError
from firmware_protocol.links import DriveSection

TIMING = DriveTiming(1e-3, 0.02)
SECTION = DriveSection(id=5, torque_nm=3.0, counts_per_turn=4096.0, rated_torque_nm=2.0)


def test_a_moteus_command_is_position_mode_with_both_gains_at_zero_and_a_watchdog() -> None:
    (frame,) = MoteusDrive(SECTION, TIMING).command(1.5)
    assert (frame.identifier, frame.extended, frame.fd) == (0x8005, True, True)
    data = frame.data
    assert data[:6] == bytes([0x01, 0x00, 0x0A, 0x0C, 0x05, 0x20])
    position, velocity, torque, kp, kd = struct.unpack_from("<5f", data, 6)
    assert math.isnan(position) and (velocity, torque, kp, kd) == (0.0, 1.5, 0.0, 0.0)
    assert data[26:28] == bytes([0x0D, 0x27]) and struct.unpack_from("<f", data, 28)[0] == pytest.approx(0.02)
    # a question for mode, position, velocity, torque, voltage, temperature and fault, then padding to a length of FD
    assert data[32:38] == bytes([0x11, 0x00, 0x1F, 0x01, 0x1F, 0x0D])
    assert len(data) == 48 and set(data[38:]) == {0x50}


def test_a_moteus_reply_is_read_in_turns_and_a_broken_one_not_at_all() -> None:
    drive = MoteusDrive(SECTION, TIMING)
    data = bytes([0x21, 0x00, 10, 0x2F, 0x01]) + struct.pack("<3f", 0.25, -1.0, 0.7)
    data += bytes([0x2E, 0x0D]) + struct.pack("<2f", 24.0, 30.0)
    assert drive.take(CanFrame(0x0500, data, False, True))
    sample = drive.sample
    assert sample.position_rad == pytest.approx(math.pi / 2) and sample.rate_rad_s == pytest.approx(-2.0 * math.pi)
    assert (sample.torque_nm, sample.supply_v, sample.temperature_degc) == (pytest.approx(0.7), 24.0, 30.0)
    assert sample.power is Power.ON and sample.updates == 1
    for length in range(len(data)):
        assert (
            replies(data[:length]) is None
            or not MoteusDrive(SECTION, TIMING).take(CanFrame(0x0500, data[:length], False, True))
            or length >= 17
        )
    assert not drive.take(CanFrame(0x0600, data, False, True))
    assert drive.sample == sample


def test_odrive_frames_carry_node_and_command_and_little_endian_floats() -> None:
    drive = OdriveDrive(SECTION, TIMING)
    (torque,) = drive.command(-0.5)
    assert (torque.identifier, torque.data, torque.extended, torque.fd) == (0xAE, struct.pack("<f", -0.5), False, False)
    mode, _, state = drive.enable()
    assert (mode.identifier, mode.data) == (0xAB, bytes([1, 0, 0, 0, 1, 0, 0, 0]))
    assert (state.identifier, state.data) == (0xA7, bytes([8, 0, 0, 0]))
    assert drive.take(CanFrame(0xA9, struct.pack("<ff", 0.5, 2.0)))
    assert drive.sample.position_rad == pytest.approx(math.pi) and drive.sample.rate_rad_s == pytest.approx(
        4.0 * math.pi
    )
    assert drive.take(CanFrame(0xA1, bytes([0, 0, 0, 0, 8, 0, 0, 0]))) and drive.sample.power is Power.ON
    assert drive.take(CanFrame(0xA1, bytes([1, 0, 0, 0, 1, 0, 0, 0]))) and drive.sample.power is Power.FAULT
    assert not drive.take(CanFrame(0xC9, struct.pack("<ff", 0.5, 2.0)))


def test_an_odrive_estimate_that_is_no_number_is_a_fault_and_not_a_position() -> None:
    drive = OdriveDrive(SECTION, TIMING)
    drive.take(CanFrame(0xA9, struct.pack("<ff", 0.5, 2.0)))
    before = drive.sample
    drive.take(CanFrame(0xA9, struct.pack("<ff", math.nan, 2.0)))
    assert drive.sample.position_rad == before.position_rad and drive.sample.power is Power.FAULT


def test_a_cia402_node_is_set_up_object_by_object_and_then_started() -> None:
    drive = Cia402Drive(SECTION, TIMING)
    (frame,) = drive.begin()
    written: list[tuple[int, int, int]] = []
    while frame.identifier == 0x605:
        kind, index, sub, value = struct.unpack("<BHBI", frame.data)
        assert kind in (0x2F, 0x2B, 0x23)
        written.append((index, sub, value))
        drive.take(CanFrame(0x585, struct.pack("<BHBI", 0x60, index, sub, 0)))
        frame = drive.ask()[0]
    assert (frame.identifier, frame.data) == (0x000, bytes([1, 5]))
    assert (0x6060, 0, 10) in written
    for mapping, objects in ((0x1600, (0x60400010, 0x60710010)), (0x1A00, (0x60410010, 0x60640020))):
        assert [value for index, _, value in written if index == mapping] == [0, *objects, 2]
    assert (0x1016, 1, 127 << 16 | 20) in written


def test_a_cia402_node_that_refuses_an_object_is_in_fault_but_may_lack_the_watch() -> None:
    for refused, power in ((0, Power.OFF), (3, Power.FAULT)):
        drive = Cia402Drive(SECTION, TIMING)
        (frame,) = (begun,) = drive.begin()
        for number in range(refused + 1):
            _, index, sub, _ = struct.unpack("<BHBI", frame.data)
            drive.take(CanFrame(0x585, struct.pack("<BHBI", 0x80 if number == refused else 0x60, index, sub, 0)))
            frame = drive.ask()[0]
        assert drive.sample.power is power
        # what comes of it that it is not set up does not hide why
        drive.take(CanFrame(0x85, struct.pack("<HB5x", 0x8130, 0x01)))
        assert ("object 0x" in drive.sample.fault) == (power is Power.FAULT)
        # a reset begins the set-up again where it was refused, and only there
        again = [frame.data for frame in drive.reset() if frame.identifier == 0x605]
        assert again == ([] if power is Power.OFF else [begun.data])


@pytest.mark.parametrize(
    ("statusword", "state"),
    [(0x0250, 0x40), (0x0231, 0x21), (0x1233, 0x23), (0x1637, 0x27), (0x0217, 0x07), (0x021F, 0x0F), (0x0218, 0x08)],
)
def test_states_of_a_statusword_are_told_apart_whatever_its_other_bits(statusword: int, state: int) -> None:
    assert state_of(statusword) == state


def test_cia402_torque_is_in_thousandths_of_the_rated_one_and_held_at_the_wire() -> None:
    drive = Cia402Drive(SECTION, TIMING)
    assert drive.command(0.5)[0].data == struct.pack("<Hh", 0x0F, 250)
    assert drive.command(-1e9)[0].data == struct.pack("<Hh", 0x0F, -32767)


def test_a_host_that_goes_takes_back_the_watch_of_a_drive_without_torque_and_of_no_other() -> None:
    drive = Cia402Drive(SECTION, TIMING)
    drive.take(CanFrame(0x185, struct.pack("<Hi", 0x40, 0)))
    (frame,) = farewell(drive)
    assert (frame.identifier, frame.data) == (0x605, struct.pack("<BHBI", 0x23, 0x1016, 1, 0))
    for powered in (0x27, 0x07, 0x0F):
        drive.take(CanFrame(0x185, struct.pack("<Hi", powered, 0)))
        assert farewell(drive) == []


def test_what_a_cia402_drive_cannot_tell_must_be_stated() -> None:
    with pytest.raises(BadInputError, match="rated_torque_nm: is missing"):
        Cia402Drive(DriveSection(id=5, torque_nm=3.0, counts_per_turn=4096.0), TIMING)


def test_each_drive_s_own_word_for_its_fault_is_told() -> None:
    moteus, odrive, cia402 = (kind(SECTION, TIMING) for kind in (MoteusDrive, OdriveDrive, Cia402Drive))
    reply = bytes([0x21, 0x00, 1, 0x2F, 0x01]) + struct.pack("<3f", 0.25, 0.0, 0.0)
    assert moteus.take(
        CanFrame(0x0500, reply + bytes([0x2F, 0x0D]) + struct.pack("<3f", 24.0, 30.0, 33.0), False, True)
    )
    assert moteus.sample.power is Power.FAULT and moteus.sample.fault == "moteus fault 33"
    assert odrive.take(CanFrame(5 << 5 | 0x01, struct.pack("<IBBBB", 0x40, 1, 0, 0, 0)))
    assert odrive.sample.fault == "ODrive error 0x00000040"
    assert cia402.take(CanFrame(0x85, struct.pack("<HB5x", 0x7305, 0x20)))
    assert cia402.take(CanFrame(0x185, struct.pack("<Hi", 0x08, 0)))
    assert cia402.sample.power is Power.FAULT and cia402.sample.fault == "error 0x7305, register 0x20"
    assert cia402.take(CanFrame(0x185, struct.pack("<Hi", 0x27, 0))) and cia402.sample.fault == ""


def test_gear_sign_and_zero_lead_from_shaft_to_joint_and_back() -> None:
    section = DriveSection(id=1, torque_nm=4.0, sign=-1, gear=8.0, zero_rad=0.5)
    sample = on_the_joint(AxisSample(1, 16.0, 8.0, None, 0.25), section)
    assert (sample.position_rad, sample.rate_rad_s, sample.torque_nm) == (-1.5, -1.0, -2.0)
    assert shaft_torque(2.0, section) == -0.25
    assert shaft_torque(100.0, section) == -0.5 and shaft_torque(math.nan, section) == 0.0


def test_the_wire_carries_four_hundred_newton_metres() -> None:
    exponent = torque_exponent(400.0)
    assert (2**17 - 1) * 0.125e-3 * 2.0**exponent >= 400.0 > (2**17 - 1) * 0.125e-3 * 2.0 ** (exponent - 1)
    assert torque_exponent(15.0) == 0


def test_what_a_drive_does_not_give_is_said_with_the_guards_that_are_absent() -> None:
    lines = missing_text(MoteusDrive.gives)
    assert any("gyro_stop" in line for line in lines) and not any("stuck_gyro_ticks" in line for line in lines)
    mapped = missing_text(frozenset())
    assert any("gyro_encoder_rad_s" in line and "stuck_gyro_ticks" in line for line in mapped)
    assert any("watchdog" in line for line in lines)
    assert len(missing_text(frozenset(Gives))) == 0


def test_a_drive_of_another_package_is_found_by_its_entry_point(monkeypatch: pytest.MonkeyPatch) -> None:
    from importlib.metadata import EntryPoint

    offered = [
        EntryPoint("acme", "firmware_protocol.adapters:OdriveDrive", GROUP),
        EntryPoint("gone", "no.such:One", GROUP),
    ]
    monkeypatch.setattr("firmware_protocol.adapters.registry.entry_points", lambda group: offered)
    assert drive_named("acme") is OdriveDrive
    with pytest.raises(BadInputError, match="gone cannot be loaded"):
        drive_named("gone")
    with pytest.raises(BadInputError, match="no drive 'moteos'; expected moteus, odrive, cia402, dbc, acme, gone"):
        drive_named("moteos")


@pytest.mark.parametrize(
    ("name", "more", "said"),
    [
        ("odrive", {"id": 64}, r"id: 64 is no node_id; expected 0 to 63"),
        ("cia402", {"torque_nm": 66.0}, r"66 N m at the shaft, and 0x6071 carries 65.534 N m at most"),
    ],
)
def test_what_no_frame_of_a_drive_can_carry_is_refused(name: str, more: dict[str, Any], said: str) -> None:
    fits = SECTION.model_dump() | {"torque_nm": 65.5}
    require_drives(name, [DriveSection(**fits), DriveSection(**fits | {"id": 63})])
    with pytest.raises(BadInputError, match=said):
        require_drives(name, [DriveSection(**fits | more), DriveSection(**fits | {"id": 62})])
