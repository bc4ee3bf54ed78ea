"""Where a virtual antenna is offered: a pseudo-terminal (serial or slcan), a Unix socket, or a CAN bus."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from firmware_protocol.errors import BadInputError, LinkError
from firmware_protocol.links import CanLinkConfig, CobsFraming, Link, SlcanDevice, UnixLink, pty_link
from firmware_protocol.opening import open_link

_EXPECTED = "serial, slcan (a pseudo-terminal; serial:PATH and slcan:PATH give it a lasting name) or unix:PATH"


class OutletKind(Enum):
    """What a host connects to."""

    SERIAL = "serial"
    SLCAN = "slcan"
    UNIX = "unix"
    CAN = "can"


@dataclass(frozen=True)
class Outlet:
    """The device's end of a link, and the path that the host opens."""

    kind: OutletKind
    link: Link
    path: str


def parse_outlet(text: str) -> tuple[OutletKind, Path | None]:
    """Kind and path of `serial`, `serial:PATH`, `slcan`, `slcan:PATH` or `unix:PATH`; BadInputError for anything else.

    A CAN bus needs more than a name: see `join_bus`.
    """
    name, _, path = text.partition(":")
    if name not in ("serial", "slcan", "unix") or (name == "unix" and not path) or text.endswith(":"):
        raise BadInputError("--link", f"{text!r} is no link", _EXPECTED)
    return OutletKind(name), Path(path) if path else None


def join_bus(config: CanLinkConfig) -> Outlet:
    """Serve as one node of the bus on which the host is another; LinkError where it cannot be opened. The host's faults
    are the host's.
    """
    return Outlet(
        OutletKind.CAN, open_link(config.model_copy(update={"faults": None})), f"{config.interface} {config.channel}"
    )


def open_outlet(kind: OutletKind, path: Path | None) -> Outlet:
    """Open the device's end of a serial, slcan or Unix link; BadInputError or LinkError with one line where it cannot
    be.
    """
    if kind is OutletKind.UNIX:
        if path is None:
            raise BadInputError("--link", "unix has no path", _EXPECTED)
        try:
            return Outlet(kind, UnixLink(path, listen=True), str(path))
        except OSError as error:
            raise LinkError(f"{path}: {error.strerror or error}; expected a path where a socket can be made") from error
    link, terminal = pty_link(SlcanDevice() if kind is OutletKind.SLCAN else CobsFraming(), path)
    return Outlet(kind, link, str(path or terminal))
