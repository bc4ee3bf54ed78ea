"""One open CAN bus through python-can: frames of any kind out and in, whoever's they are, and never a wait.

The antenna's own link and drives of another make read the same bus; an slcan adapter has the same reader for both.
"""

from __future__ import annotations

import errno
import logging
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from firmware_protocol.errors import LinkError
from firmware_protocol.links.can_errors import error_words
from firmware_protocol.links.can_frame import CanFrame
from firmware_protocol.links.claims import PortClaim, reason_of
from firmware_protocol.links.descriptor import DescriptorPort, wait_readable
from firmware_protocol.links.slcan_port import SlcanPort
from firmware_protocol.links.slcan_text import frame_of, line_of

#: of one call: frames, and broken lines passed over
_MOST_FRAMES, _MOST_BROKEN = 4096, 64

#: the interface's own errors that mean that the bus is gone, not just full
_GONE = {errno.ENODEV, errno.ENETDOWN, errno.ENXIO, errno.EIO, errno.EBADF, errno.EPIPE}


class PythonCanBus:
    """Any interface of python-can, read without its Notifier thread; FD where a data bit rate is given. `options` go to
    python-can as they are. LinkError when it cannot be opened; for a serial port that another program has, nothing was
    sent to it.
    """

    def __init__(
        self,
        interface: str,
        channel: str | int,
        bitrate: int,
        data_bitrate: int | None = None,
        options: Mapping[str, Any] | None = None,
    ) -> None:
        import can

        # python-can warns of buses that it failed to open; the LinkError says it already
        logging.getLogger("can").setLevel(logging.ERROR)
        self._message, self._error = can.Message, can.CanError
        self._early: Any = None
        self._malformed = 0
        #: what error frames told, how often
        self.errors: Counter[str] = Counter()
        #: where the interface is slcan, its lines; frames need not be made of them one by one
        self.slcan: SlcanPort | None = None
        claim: PortClaim | None = None
        try:
            if interface == "slcan":
                claim = _claimed(str(channel))
                given = {"bitrate": bitrate, "sleep_after_open": 0.0, "timeout": 0.0, **(options or {})}
            elif data_bitrate is None:
                given = {"bitrate": bitrate, **(options or {})}
            else:
                given = {"fd": True, "bitrate": bitrate, "data_bitrate": data_bitrate, **(options or {})}
            self._bus: Any = can.Bus(channel=channel, interface=interface, ignore_config=True, **given)
            if interface == "slcan":
                self._open_lines(claim, bitrate, data_bitrate)
        except Exception as error:  # every interface fails in its own way: missing driver, port, permission, option
            if claim is not None:
                claim.release()
            raise LinkError(
                f"link: can {interface} {channel}: {reason_of(error)}; expected an interface and a channel that "
                "python-can can open"
            ) from error

    def send(self, frame: CanFrame) -> bool:
        """Whether there was room for it; OSError when the bus is gone."""
        if self.slcan is not None:
            with suppress(ValueError):
                return self.slcan.send(line_of(frame))
            return False
        try:
            message = self._message(
                arbitration_id=frame.identifier,
                data=frame.data,
                is_extended_id=frame.extended,
                is_fd=frame.fd,
                bitrate_switch=frame.fd,
            )
            self._bus.send(message, timeout=0)
        except (self._error, OSError, ValueError) as error:
            number = _number(error)
            if number in _GONE:
                raise OSError(number, str(error)) from error
            return False
        return True

    def receive(self) -> list[CanFrame]:
        """Data frames that have come; OSError when the bus is gone."""
        if self.slcan is not None:
            frames = [frame_of(line) for line in self.slcan.receive()]
            found = [frame for frame in frames if frame is not None]
            self._malformed += len(frames) - len(found)
            return found
        found = []
        for _ in range(_MOST_FRAMES):
            message, self._early = self._early or self._next(0.0), None
            if message is None:
                break
            if message.is_error_frame or message.is_remote_frame:
                self._malformed += 1
                if message.is_error_frame:
                    self.errors.update(error_words(message.arbitration_id))
            else:
                found.append(
                    CanFrame(message.arbitration_id, bytes(message.data), message.is_extended_id, message.is_fd)
                )
        return found

    def wait(self, timeout_ns: int) -> bool:
        """Sleep until a frame has come, at most that long; OSError when the bus is gone."""
        descriptor = self.fileno()
        if self._early is None and descriptor >= 0:
            return wait_readable(descriptor, timeout_ns)
        if self._early is None:
            self._early = self._next(max(0, timeout_ns) * 1e-9)
        return self._early is not None

    def take_malformed(self) -> int:
        """Frames and lines since the last call that were no data frames."""
        malformed, self._malformed = self._malformed, 0
        return malformed + (0 if self.slcan is None else self.slcan.take_malformed())

    def fileno(self) -> int:
        """Descriptor of the interface, -1 where it has none."""
        if self.slcan is not None:
            return self.slcan.fileno()
        with suppress(Exception):
            return int(self._bus.fileno())
        return -1

    def close(self) -> None:
        """Leave the bus."""
        # an interface that has gone may fail in any way while it is being left
        with suppress(Exception):
            self._bus.shutdown()
        if self.slcan is not None:  # python-can leaves the port open when its farewell cannot be written
            with suppress(Exception):
                self.slcan.close()

    def _next(self, timeout_s: float) -> Any:
        """A message of the interface, or None."""
        for _ in range(_MOST_BROKEN):
            try:
                return self._bus.recv(timeout_s)
            except (ValueError, IndexError):  # an interface that speaks text stumbles over a broken line
                self._malformed += 1
            except (self._error, OSError) as error:
                raise OSError(_number(error) or errno.EIO, str(error)) from error
        return None

    def _open_lines(self, claim: PortClaim | None, bitrate: int, data_bitrate: int | None) -> None:
        """From here on lines are read and written in bulk, by nobody else."""
        terminal = self._bus.serialPortOrig
        try:
            if data_bitrate is not None:
                self._bus.set_bitrate(bitrate, data_bitrate)
            if claim is not None:
                claim.exclude(terminal.fileno())
        except Exception:
            terminal.close()
            raise

        def release() -> None:
            if claim is not None:
                claim.give_back()
            terminal.close()
            if claim is not None:
                claim.release()

        self.slcan = self._bus.serialPortOrig = SlcanPort(DescriptorPort(terminal.fileno(), release))


def _claimed(channel: str) -> PortClaim | None:
    """The claim on a port; none on a name that python-can asks a network for."""
    return None if "://" in channel else PortClaim(channel.partition("@")[0])


def _number(error: BaseException) -> int | None:
    code = getattr(error, "error_code", None)
    return code if code is not None else getattr(error, "errno", None)
