"""Host and virtual antenna in lockstep over the bytes of a real transport, with trouble on the line at will."""

from __future__ import annotations

import random
from collections.abc import Callable
from enum import StrEnum

import numpy as np

from firmware_protocol import codec
from firmware_protocol.links import CobsFraming, Framing, SlcanDevice
from firmware_protocol.schema import BY_CAN_ID, BY_NAME, name_code
from gimbal_hil.loop.host import Host, HostEvent
from gimbal_hil.loop.settings import DaemonSettings, host_configuration
from gimbal_hil.proof.bench.faults.rows import FaultRow, Trouble
from sim_backend.device import Device
from sim_backend.firmware import close_firmware, run_firmware
from sim_backend.firmware_run import FirmwareRun
from sim_backend.layout import TEMPERATURE
from sim_backend.model import AntennaModel

#: changes the records of a block on their way
Change = Callable[[bytes], bytes]
_FEEDBACK = ("feedback_outer", "feedback_inner")


class Transport(StrEnum):
    """What carries the frames."""

    SERIAL = "serial"
    CAN = "can"


class Line:
    """Blocks as bytes and back: packets with a CRC-16 of their own on a serial line, lines of text on an slcan
    adapter.
    """

    def __init__(self, transport: Transport) -> None:
        self._host: Framing = CobsFraming() if transport is Transport.SERIAL else _open_adapter()
        # an adapter answers frames in the very form in which it takes them
        self._antenna: Framing = CobsFraming() if transport is Transport.SERIAL else _open_adapter()

    def to_antenna(self, block: bytes) -> bytes:
        """What the antenna gets of what the host sent."""
        return _carried(self._host, self._antenna, block)

    def to_host(self, block: bytes) -> bytes:
        """What the host gets of what the antenna sent."""
        return _carried(self._antenna, self._host, block)


def _carried(near: Framing, far: Framing, block: bytes) -> bytes:
    arrived = far.feed(near.encode(block))
    far.answer()
    return arrived


def _open_adapter() -> SlcanDevice:
    adapter = SlcanDevice()
    adapter.feed(b"O\r")
    return adapter


class Rig:
    """One antenna, its host and their line."""

    def __init__(
        self,
        settings: DaemonSettings,
        model: AntennaModel,
        transport: Transport,
        seed: int,
        firmware: FirmwareRun = FirmwareRun.VIRTUAL,
    ) -> None:
        self.host = Host(host_configuration(settings))
        self._model, self._settings, self._seed, self._firmware = model, settings, seed, firmware
        self.device = self._powered(seed)
        self.line, self.tick, self.step_ns = Line(transport), 0, round(1e9 / settings.rate_hz)
        self.events: list[HostEvent] = []
        self.host_speaks, self.set_points_pass, self.antenna_heard = True, True, True
        self.change: Change | None = None
        self._answer = b""

    def advance(self, ticks: int) -> np.ndarray:
        """Run; answers the true joint positions and rates after each tick, (ticks, 4)."""
        motion = np.empty((ticks, 4))
        for row in motion:
            answer = self._answer if self.antenna_heard else b""
            if self.change is not None:
                answer = self.change(answer)
            received = self.line.to_host(answer)
            sent = self.host.tick(self.tick, self.tick * self.step_ns, received)
            if not self.set_points_pass:
                sent = _without(sent, "set_point")
            self._answer = self.device.tick(self.line.to_antenna(sent) if self.host_speaks else b"")
            self.events += self.host.events()
            row[:2], row[2:] = self.device.joint_positions, self.device.joint_rates
            self.tick += 1
        return motion

    def suffer(self, row: FaultRow) -> None:
        """Let the fault of a row come."""
        if row.trouble is None:
            self.device.spoil(row.axis, row.part, row.kind, row.amount)
        else:
            _begin(self, row)

    def stall(self, ticks: int) -> None:
        """The host's machine stands still for so many ticks; the antenna goes on."""
        for _ in range(ticks):
            self._answer += self.device.tick()
        self.tick += ticks

    def restart_antenna(self) -> None:
        """Its electronics begin anew; the mechanics go on as they moved."""
        before = self.device
        self.device = self._powered(self._seed + 1)
        self.device.X[:] = before.X
        close_firmware(before)

    def close(self) -> None:
        """Give back what the firmware runs on."""
        close_firmware(self.device)

    def _powered(self, seed: int) -> Device:
        return run_firmware(self._firmware, self._model, self._settings.rate_hz, seed)


def _without(block: bytes, name: str) -> bytes:
    wanted = [(can_id, payload) for can_id, payload in codec.records(block) if can_id != BY_NAME[name].can_id]
    return b"".join(codec.record(can_id, payload) for can_id, payload in wanted)


def _frozen(names: tuple[str, ...]) -> Change:
    """The fields of these messages stay as first seen; counters and CRC stay alive."""
    kept: dict[int, tuple[int, ...]] = {}

    def change(block: bytes) -> bytes:
        changed = []
        for can_id, payload in codec.records(block):
            definition = BY_CAN_ID[can_id]
            raw = codec.unpack_raw(definition, payload)
            if definition.name in names and isinstance(raw, tuple):
                payload = codec.pack_raw(definition, kept.setdefault(can_id, raw), codec.alive_counter(payload))
            changed.append(codec.record(can_id, payload))
        return b"".join(changed)

    return change


def _damaged(seed: int) -> Change:
    draw = random.Random(seed)

    def change(block: bytes) -> bytes:
        octets = bytearray(block)
        for at in range(0, len(octets), 10):
            if draw.random() < 0.02:
                octets[at + 2 + draw.randrange(8)] ^= 1 << draw.randrange(8)
        return bytes(octets)

    return change


def _stranger(block: bytes) -> bytes:
    """Another antenna says who it is, unasked."""
    definition = BY_NAME["identity"]
    return block + codec.record(definition.can_id, codec.pack_raw(definition, (2, name_code("a stranger"), 0, 1), 5))


def _hot(rig: Rig, row: FaultRow) -> None:
    rig.device.X[TEMPERATURE + row.axis] = 140.0


def _change(change: Change) -> Callable[[Rig, FaultRow], None]:
    def begin(rig: Rig, row: FaultRow) -> None:
        rig.change = change

    return begin


def _cut(*what: str) -> Callable[[Rig, FaultRow], None]:
    def begin(rig: Rig, row: FaultRow) -> None:
        for name in what:
            setattr(rig, name, False)

    return begin


def _begin(rig: Rig, row: FaultRow) -> None:
    """Let the trouble of a row come."""
    makers: dict[Trouble, Callable[[], Callable[[Rig, FaultRow], None]]] = {
        Trouble.FEEDBACK_CUT: lambda: _cut("antenna_heard"),
        Trouble.LINE_CUT: lambda: _cut("antenna_heard", "host_speaks"),
        Trouble.SET_POINTS_LOST: lambda: _cut("set_points_pass"),
        Trouble.HOST_SILENT: lambda: _cut("host_speaks"),
        Trouble.FEEDBACK_FROZEN: lambda: _change(_frozen(_FEEDBACK)),
        Trouble.STATUS_FROZEN: lambda: _change(_frozen((*_FEEDBACK, "drive_status"))),
        Trouble.ANTENNA_RESTARTED: lambda: lambda rig, row: rig.restart_antenna(),
        Trouble.STRANGER: lambda: _change(_stranger),
        Trouble.UNDERVOLTAGE: lambda: lambda rig, row: rig.device.set_supply(12.0),
        Trouble.HOT_WINDING: lambda: _hot,
        Trouble.NOISY_LINE: lambda: _change(_damaged(row.axis)),
        Trouble.QUICK_STOP: lambda: lambda rig, row: rig.host.quick_stop(),
    }
    assert row.trouble is not None
    makers[row.trouble]()(rig, row)
