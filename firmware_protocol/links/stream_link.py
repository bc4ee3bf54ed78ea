"""A link over a stream of bytes: some port that carries them, some framing that finds the frames in them."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Protocol

from firmware_protocol.links.descriptor import DescriptorPort, wait_readable
from firmware_protocol.links.link import LinkBasis, LinkState
from firmware_protocol.stream import DELIMITER, StreamParser, encode_packets


class Framing(Protocol):
    """Blocks in a byte stream, without input or output of its own."""

    #: bytes that set the other end right when a connection begins
    greeting: bytes

    def encode(self, block: bytes) -> bytes:
        """Bytes that carry a block."""

    def feed(self, octets: bytes) -> bytes:
        """Block of all frames that these bytes complete."""

    def answer(self) -> bytes:
        """Bytes that the framing itself has to send since the last call."""

    def reset(self) -> None:
        """Forget half of a frame."""

    @property
    def malformed(self) -> int:
        """Packets or lines that were dropped."""


class CobsFraming:
    """Packets of `firmware_protocol.stream`."""

    greeting = DELIMITER

    def __init__(self) -> None:
        self._parser = StreamParser()

    def encode(self, block: bytes) -> bytes:
        return encode_packets(block)

    def feed(self, octets: bytes) -> bytes:
        return self._parser.feed(octets)

    def answer(self) -> bytes:
        return b""

    def reset(self) -> None:
        self._parser.reset()

    @property
    def malformed(self) -> int:
        return self._parser.counts.bad


class StreamLink(LinkBasis):
    """Frames over a terminal, pseudo-terminal or stream socket. `open_port` raises LinkError when it cannot."""

    def __init__(self, name: str, open_port: Callable[[], DescriptorPort], framing: Framing) -> None:
        super().__init__(name)
        self._open_port = open_port
        self._framing = framing
        self._port: DescriptorPort | None = None
        self._connect()

    def send(self, block: bytes) -> None:
        """Send whole records; dropped and counted when the peer's buffer is full."""
        if block:
            self._count_sent(block, self._write(self._framing.encode(block)))

    def receive(self) -> bytes:
        """Frames that have come whole since the last call."""
        if self._port is None:
            return b""
        try:
            octets = self._port.read()
        except OSError as error:
            self._lose(error)
            return b""
        if not octets:
            return b""
        block = self._framing.feed(octets)
        answer = self._framing.answer()
        if answer:
            self._write(answer)
        self._statistics.malformed = self._framing.malformed
        return self._count_received(block)

    def wait(self, timeout_ns: int) -> bool:
        """Sleep until bytes have come, at most that long."""
        return self._port is not None and wait_readable(self._port.descriptor, timeout_ns)

    def close(self) -> None:
        """Give the port back."""
        self._release()
        self._state = LinkState.CLOSED

    def fileno(self) -> int:
        """Descriptor of the port, -1 while it is lost."""
        return -1 if self._port is None else self._port.descriptor

    def _connect(self) -> None:
        self._port = self._open_port()
        self._framing.reset()
        self._opened()
        self._write(self._framing.greeting)

    def _write(self, octets: bytes) -> bool:
        if self._port is None:
            return False
        try:
            return self._port.write(octets)
        except OSError as error:
            self._lose(error)
            return False

    def _lose(self, reason: object) -> None:
        self._release()
        self._lost(reason)

    def _release(self) -> None:
        if self._port is not None:
            with suppress(OSError):
                self._port.close()
            self._port = None
