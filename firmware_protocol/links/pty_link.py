"""The device's end of a pseudo-terminal, so that a virtual antenna looks like a serial port or an slcan adapter."""

from __future__ import annotations

import os
import tty
from contextlib import suppress
from pathlib import Path

from firmware_protocol.errors import LinkError
from firmware_protocol.links.descriptor import DescriptorPort
from firmware_protocol.links.name_lock import NameLock
from firmware_protocol.links.stream_link import CobsFraming, Framing, StreamLink


def pty_link(framing: Framing | None = None, symlink: Path | None = None) -> tuple[StreamLink, str]:
    """A link on a new pseudo-terminal, and the path that the other program opens.

    `framing` is that of `stream` unless given (`SlcanDevice` for slcan). `symlink` gives the path a name that stays the
    same when the device is started again; an old link of that name is replaced, anything else there is refused, and so
    is a name that a process serves.
    """
    lock = None if symlink is None else NameLock(symlink)
    device, terminal = os.openpty()
    # kept open: the settings stay raw, and the device does not lose its port whenever a host comes or goes
    tty.setraw(terminal)
    path = os.ttyname(terminal)
    if symlink is not None:
        try:
            _point(symlink, path)
        except OSError as error:
            os.close(device)
            os.close(terminal)
            if lock is not None:
                lock.release()
            raise LinkError(
                f"{symlink}: {error.strerror or error}; expected a path where a symbolic link can be made"
            ) from error

    def release() -> None:
        os.close(device)
        os.close(terminal)
        if symlink is not None and symlink.is_symlink() and os.readlink(symlink) == path:
            with suppress(OSError):
                symlink.unlink()
        if lock is not None:
            lock.release()

    return StreamLink(f"pty {symlink or path}", lambda: DescriptorPort(device, release), framing or CobsFraming()), path


def _point(symlink: Path, path: str) -> None:
    fresh = symlink.with_name(f".{symlink.name}.{os.getpid()}")
    if symlink.exists() and not symlink.is_symlink():
        raise FileExistsError(f"{symlink} exists and is no symbolic link")
    with suppress(FileNotFoundError):
        fresh.unlink()
    fresh.symlink_to(path)
    fresh.replace(symlink)
