"""Who has a port or a bus: one program at a time commands what is behind it, and a refusal says which one that is."""

from __future__ import annotations

import errno
import fcntl
import os
import re
import socket
import struct
import termios
from contextlib import suppress
from pathlib import Path

from firmware_protocol.errors import LinkError

_PROCESSES = Path("/proc")
_TEXT_LIMIT = 80
#: the descriptor of a pseudo-terminal's other end
_OTHER_END = ("/dev/ptmx", "/dev/pts/ptmx")


class PortClaim:
    """A serial port from before its first byte until `release`; the system gives it back when the process dies.

    OSError where the port cannot be opened, with EBUSY and who has it where another program does. Both are asked: the
    advisory lock that pyserial takes too, and which programs hold it open without one.
    """

    def __init__(self, port: str) -> None:
        self._port = os.path.realpath(port)
        self._descriptor = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK | os.O_CLOEXEC)
        self._excluding = -1
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if users := _users_of(self._port):
                raise _busy(users[0])
        except BlockingIOError:
            holder = _holder_of_lock(self._descriptor) or next(iter(_users_of(self._port)), None)
            self.release()
            raise _busy(holder) from None
        except OSError:
            self.release()
            raise

    def exclude(self, descriptor: int) -> None:
        """Keep other programs from opening the port through `descriptor`, beside the lock that only those see who ask.

        Not a pseudo-terminal: its other end keeps it open, and the claim of a host that was killed would outlive it.
        """
        if not self._port.startswith("/dev/pts/"):
            with suppress(OSError):
                fcntl.ioctl(descriptor, termios.TIOCEXCL)
                self._excluding = descriptor

    def give_back(self) -> None:
        """Let others open the port again; before its descriptor is closed."""
        if self._excluding >= 0:
            with suppress(OSError):
                fcntl.ioctl(self._excluding, termios.TIOCNXCL)
            self._excluding = -1

    def release(self) -> None:
        """Let the port go; after its descriptor was closed."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1


class BusClaim:
    """The host's part on a bus that any number of programs may open at once (SocketCAN), by a name that the system
    forgets with the process. LinkError says who has it. A name is of one network namespace, as a CAN interface is.
    """

    def __init__(self, bus: str, name: str = "") -> None:
        address = f"\0gimbal-hil host of {name or bus}"
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self._socket.bind(address)
            self._socket.listen(1)
        except OSError as error:
            self._socket.close()
            raise LinkError(f"link: {bus}: {_busy(_listener_at(address)).strerror}; expected that one ended") from error

    @classmethod
    def of_socket(cls, bus: str, path: Path) -> BusClaim | None:
        """The host's part on a Unix socket, where a second host would wait unheard; None where there is no socket. By
        the file's number: a path has several spellings, and may be longer than a name.
        """
        try:
            place = path.stat()
        except OSError:
            return None
        return cls(bus, f"socket {place.st_dev}:{place.st_ino}")

    def release(self) -> None:
        """Let the bus go."""
        self._socket.close()


def reason_of(error: Exception) -> str:
    """Why a port cannot be opened, in a few words."""
    number = getattr(error, "errno", None)
    if number == errno.ENOENT:
        return "no such port"
    if number in (errno.EBUSY, errno.EAGAIN):
        said = getattr(error, "strerror", None) or ""
        return said if said.startswith("busy: ") else "busy: another program has this port"
    if number in (errno.EACCES, errno.EPERM):
        return "no permission to open it (on Linux: join the group dialout)"
    if number == errno.ECONNREFUSED:
        return "connection refused: nobody listens there"
    return str(error) or type(error).__name__


def _busy(process: int | None) -> OSError:
    who = "another program" if process is None else f"process {process}{_command_of(process)}"
    return OSError(errno.EBUSY, f"busy: {who} has it")


def _command_of(process: int) -> str:
    with suppress(OSError):
        words = (_PROCESSES / str(process) / "cmdline").read_bytes().decode(errors="replace").split("\0")
        text = " ".join([Path(words[0]).name, *words[1:]]).strip()
        text = "".join(letter if letter.isprintable() else "?" for letter in text)
        if text:
            return f" ({text if len(text) <= _TEXT_LIMIT else text[:_TEXT_LIMIT] + '...'})"
    return ""


def _holder_of_lock(descriptor: int) -> int | None:
    """The process that holds the lock on a descriptor's file."""
    file = os.fstat(descriptor)
    place = f"{os.major(file.st_dev):02x}:{os.minor(file.st_dev):02x}:{file.st_ino}"
    with suppress(OSError):
        for line in (_PROCESSES / "locks").read_text().splitlines():
            found = re.match(r"\d+: FLOCK +\S+ +WRITE +(\d+) +(\S+) ", line)
            if found and found[2] == place and int(found[1]) > 0:
                return int(found[1])
    return None


def _users_of(path: str) -> list[int]:
    """Other processes that hold a port open, as far as this one may look: not one that is a pseudo-terminal's other
    end, which keeps it open for whoever comes.
    """
    found = []
    for folder in _PROCESSES.iterdir():
        if not folder.name.isdigit() or int(folder.name) == os.getpid():
            continue
        with suppress(OSError):
            opened = {_target(one) for one in (folder / "fd").iterdir()}
            if path in opened and not opened.intersection(_OTHER_END):
                found.append(int(folder.name))
    return found


def _target(link: Path) -> str:
    with suppress(OSError):
        return os.readlink(link)
    return ""


def _listener_at(address: str) -> int | None:
    with suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as asking:
        asking.setblocking(False)
        asking.connect(address)
        told = asking.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i"))
        return int(struct.unpack("3i", told)[0])
    return None
