"""A link over a CAN bus through python-can: any interface that it knows, read in bulk, without its Notifier thread."""

from __future__ import annotations

import errno
import logging
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from firmware_protocol.codec import record, records
from firmware_protocol.errors import LinkError
from firmware_protocol.links.descriptor import DescriptorPort, wait_readable
from firmware_protocol.links.link import BLOCK_LIMIT, LinkBasis, LinkState
from firmware_protocol.links.slcan_port import SlcanPort
from firmware_protocol.schema import PAYLOAD_SIZE, RECORD_SIZE

_FRAMES = BLOCK_LIMIT // RECORD_SIZE

#: broken lines passed over in one call
_BROKEN_LINES = 64

#: the interface's own errors that mean that the bus is gone, not just full
_GONE = {errno.ENODEV, errno.ENETDOWN, errno.ENXIO, errno.EIO, errno.EBADF, errno.EPIPE}


class CanLink(LinkBasis):
    """Frames on a CAN bus. `options` go to python-can as they are; LinkError when the bus cannot be opened."""

    def __init__(
        self, interface: str, channel: str | int, bitrate: int, options: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__(f"can {interface} {channel}")
        self._interface, self._channel, self._bitrate = interface, channel, bitrate
        self._options = dict(options or {})
        self._bus: Any = None
        self._slcan: SlcanPort | None = None
        self._early: Any = None
        self._connect()

    def send(self, block: bytes) -> None:
        """Send whole records; dropped and counted when the controller's queue is full."""
        if self._slcan is not None:
            self._count_sent(block, self._send_lines(self._slcan, block))
        elif self._bus is None:
            self._count_sent(block, False)
        else:
            for can_id, payload in records(block):
                self._send_frame(can_id, payload)

    def receive(self) -> bytes:
        """Standard data frames of eight bytes that have come since the last call; others are counted as malformed."""
        if self._slcan is not None:
            return self._count_received(self._received_lines(self._slcan))
        taken: list[bytes] = []
        if self._early is not None:
            self._take(self._early, taken)
            self._early = None
        for _ in range(_FRAMES):
            frame = self._receive_frame(0.0)
            if frame is None:
                break
            self._take(frame, taken)
        return self._count_received(b"".join(taken))

    def wait(self, timeout_ns: int) -> bool:
        """Sleep until a frame has come, at most that long."""
        if self._early is not None or self._bus is None:
            return self._early is not None
        descriptor = self.fileno()
        if descriptor >= 0:
            return wait_readable(descriptor, timeout_ns)
        self._early = self._receive_frame(max(0, timeout_ns) * 1e-9)
        return self._early is not None

    def close(self) -> None:
        """Leave the bus."""
        self._release()
        self._state = LinkState.CLOSED

    def fileno(self) -> int:
        """Descriptor of the interface, -1 where it has none."""
        if self._slcan is not None:
            return self._slcan.fileno()
        with suppress(Exception):
            return int(self._bus.fileno())
        return -1

    def _connect(self) -> None:
        import can

        # python-can warns of buses that it failed to open; the LinkError says it already
        logging.getLogger("can").setLevel(logging.ERROR)
        options: dict[str, Any] = {"bitrate": self._bitrate, **self._options}
        if self._interface == "slcan":
            options = {"sleep_after_open": 0.0, "timeout": 0.0, **options}
        try:
            self._bus = can.Bus(channel=self._channel, interface=self._interface, ignore_config=True, **options)
        except Exception as error:  # every interface fails in its own way: missing driver, port, permission, option
            raise LinkError(
                f"link: {self._name}: {error}; expected an interface and a channel that python-can can open"
            ) from error
        self._message, self._error = can.Message, can.CanError
        if self._interface == "slcan":
            self._slcan = self._bus.serialPortOrig = self._bulk_port()
        self._early = None
        self._opened()

    def _bulk_port(self) -> SlcanPort:
        terminal = self._bus.serialPortOrig
        return SlcanPort(DescriptorPort(terminal.fileno(), terminal.close))

    def _send_frame(self, can_id: int, payload: bytes) -> None:
        if self._bus is None:
            self._statistics.frames_dropped += 1
            return
        message = self._message(arbitration_id=can_id, data=payload, is_extended_id=False)
        try:
            self._bus.send(message, timeout=0)
        except (self._error, OSError, ValueError) as error:
            self._statistics.frames_dropped += 1
            if _number(error) in _GONE:
                self._lose(error)
        else:
            self._statistics.frames_sent += 1

    def _receive_frame(self, timeout_s: float) -> Any:
        for _ in range(_BROKEN_LINES):
            if self._bus is None:
                return None
            try:
                return self._bus.recv(timeout_s)
            except (ValueError, IndexError):  # an interface that speaks text stumbles over a broken line
                self._statistics.malformed += 1
            except (self._error, OSError) as error:
                self._lose(error)
        return None

    def _send_lines(self, port: SlcanPort, block: bytes) -> bool:
        try:
            return port.send(block)
        except OSError as error:
            self._lose(error)
            return False

    def _received_lines(self, port: SlcanPort) -> bytes:
        try:
            block = port.receive()
        except OSError as error:
            self._lose(error)
            return b""
        self._statistics.malformed += port.take_malformed()
        return block

    def _take(self, frame: Any, taken: list[bytes]) -> None:
        foreign = frame.is_extended_id or frame.is_remote_frame or frame.is_error_frame or frame.is_fd
        if foreign or frame.dlc != PAYLOAD_SIZE or len(frame.data) != PAYLOAD_SIZE:
            self._statistics.malformed += 1
        else:
            taken.append(record(frame.arbitration_id, bytes(frame.data)))

    def _lose(self, reason: object) -> None:
        self._release()
        self._lost(reason)

    def _release(self) -> None:
        bus, slcan, self._bus, self._slcan = self._bus, self._slcan, None, None
        # an interface that has gone may fail in any way while it is being left
        if bus is not None:
            with suppress(Exception):
                bus.shutdown()
        if slcan is not None:  # python-can leaves the port open when its farewell cannot be written
            with suppress(Exception):
                slcan.close()


def _number(error: BaseException) -> int | None:
    code = getattr(error, "error_code", None)
    return code if code is not None else getattr(error, "errno", None)
