"""A link over a CAN bus through python-can: any interface that it knows, read in bulk, without its Notifier thread."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeVar

from firmware_protocol.codec import record, records
from firmware_protocol.links.can_bus import PythonCanBus
from firmware_protocol.links.can_frame import CanFrame
from firmware_protocol.links.link import LinkBasis, LinkState
from firmware_protocol.links.slcan_port import SlcanPort
from firmware_protocol.links.slcan_text import lines_of, record_of
from firmware_protocol.schema import PAYLOAD_SIZE

_What = TypeVar("_What", bytes, CanFrame)


class CanLink(LinkBasis):
    """Frames on a CAN bus. `options` go to python-can as they are; LinkError when the bus cannot be opened."""

    def __init__(
        self, interface: str, channel: str | int, bitrate: int, options: Mapping[str, object] | None = None
    ) -> None:
        super().__init__(f"can {interface} {channel}")
        self._interface, self._channel, self._bitrate = interface, channel, bitrate
        self._options = dict(options or {})
        self._bus: PythonCanBus | None = None
        self._connect()

    def send(self, block: bytes) -> None:
        """Send whole records; dropped and counted when the controller's queue is full."""
        bus = self._bus
        if bus is not None and bus.slcan is not None:
            self._count_sent(block, self._tried(bus.slcan.send, lines_of(block)))
            return
        for can_id, payload in records(block):
            sent = self._bus is not None and self._tried(self._bus.send, CanFrame(can_id, payload))
            self._count_sent(record(can_id, payload), sent)

    def receive(self) -> bytes:
        """Standard data frames of eight bytes that have come since the last call; others are counted as malformed."""
        bus = self._bus
        if bus is None:
            return b""
        try:
            found = _records_of(bus.slcan) if bus.slcan is not None else [_record(frame) for frame in bus.receive()]
        except OSError as error:
            self._lose(error)
            return b""
        self._statistics.malformed += found.count(b"") + bus.take_malformed()
        return self._count_received(b"".join(found))

    def wait(self, timeout_ns: int) -> bool:
        """Sleep until a frame has come, at most that long."""
        try:
            return self._bus is not None and self._bus.wait(timeout_ns)
        except OSError as error:
            self._lose(error)
            return False

    def close(self) -> None:
        """Leave the bus."""
        self._release()
        self._state = LinkState.CLOSED

    def fileno(self) -> int:
        """Descriptor of the interface, -1 where it has none."""
        return -1 if self._bus is None else self._bus.fileno()

    def _connect(self) -> None:
        self._bus = PythonCanBus(self._interface, self._channel, self._bitrate, options=self._options)
        self._opened()

    def _tried(self, send: Callable[[_What], bool], what: _What) -> bool:
        try:
            return send(what)
        except OSError as error:
            self._lose(error)
            return False

    def _lose(self, reason: object) -> None:
        self._release()
        self._lost(reason)

    def _release(self) -> None:
        bus, self._bus = self._bus, None
        if bus is not None:
            bus.close()


def _records_of(port: SlcanPort) -> list[bytes]:
    return [record_of(line) for line in port.receive()]


def _record(frame: CanFrame) -> bytes:
    """Its record; nothing for a frame that is not one of ours."""
    foreign = frame.extended or frame.fd or len(frame.data) != PAYLOAD_SIZE
    return b"" if foreign else record(frame.identifier, frame.data)
