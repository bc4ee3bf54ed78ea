"""The CiA 402 adapter sets up a node of an independent CANopen stack, whose server checks every transfer."""

from __future__ import annotations

import time

import pytest

from firmware_protocol.adapters import Cia402Drive, DriveTiming, PythonCanBus
from firmware_protocol.links import DriveSection

pytestmark = pytest.mark.realtime

canopen = pytest.importorskip("canopen", reason="canopen is not installed (the extra test has it)")
CHANNEL, NODE = "canopen-stack", 7


def dictionary() -> object:
    """Objects of a drive with three PDOs."""
    from canopen.objectdictionary import ODRecord, ODVariable, datatypes

    found = canopen.ObjectDictionary()
    words = {1: datatypes.UNSIGNED8, 2: datatypes.UNSIGNED16, 4: datatypes.UNSIGNED32}
    records = {
        0x1016: (4,),
        0x1400: (4, 1),
        0x1800: (4, 1),
        0x1801: (4, 1),
        0x1600: (4, 4),
        0x1A00: (4, 4),
        0x1A01: (4, 4),
    }
    for index, sizes in records.items():
        record = ODRecord(f"object {index:x}", index)
        for sub, size in enumerate((1, *sizes)):
            variable = ODVariable(f"entry {sub}", index, sub)
            variable.data_type = words[size]
            record.add_member(variable)
        found.add_object(record)
    mode = ODVariable("modes of operation", 0x6060)
    mode.data_type = datatypes.INTEGER8
    found.add_object(mode)
    return found


def test_every_object_arrives_as_it_was_meant() -> None:
    network = canopen.Network()
    network.connect(interface="virtual", channel=CHANNEL)
    node = network.create_node(NODE, dictionary())
    bus = PythonCanBus("virtual", CHANNEL, 1_000_000)
    drive = Cia402Drive(
        DriveSection(id=NODE, torque_nm=3.0, counts_per_turn=4096.0, rated_torque_nm=2.0), DriveTiming(1e-3, 0.05)
    )
    try:
        pending = drive.begin()
        end = time.monotonic() + 20.0
        while time.monotonic() < end and not any(frame.identifier == 0x000 for frame in pending):
            for frame in pending:
                bus.send(frame)
            time.sleep(0.002)
            for frame in bus.receive():
                drive.take(frame)
            pending = [frame for frame in drive.ask() if frame.identifier in (0x000, 0x600 + NODE)]
        assert [frame.data for frame in pending] == [bytes([1, NODE])]
        stored = {
            (index, sub): int.from_bytes(node.get_data(index, sub), "little")
            for index, sub in (
                (0x6060, 0),
                (0x1600, 0),
                (0x1600, 2),
                (0x1A01, 1),
                (0x1400, 1),
                (0x1800, 1),
                (0x1016, 1),
            )
        }
    finally:
        bus.close()
        network.disconnect()
    assert stored == {
        (0x6060, 0): 10,
        (0x1600, 0): 2,
        (0x1600, 2): 0x60710010,
        (0x1A01, 1): 0x606C0020,
        (0x1400, 1): 0x200 + NODE,
        (0x1800, 1): 0x180 + NODE,
        (0x1016, 1): 127 << 16 | 50,
    }
