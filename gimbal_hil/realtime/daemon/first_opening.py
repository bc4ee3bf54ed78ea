"""The first try to open a link: tells a port that is not there yet from one that is wrong."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from firmware_protocol.errors import LinkError
from firmware_protocol.links import AdapterLinkConfig, CanLinkConfig, Link, SerialLinkConfig, UnixLinkConfig
from firmware_protocol.opening import open_link

PortConfig = CanLinkConfig | SerialLinkConfig | UnixLinkConfig | AdapterLinkConfig
#: device nodes come with a driver, not with an antenna that is started later
_DEVICES = Path("/dev")


def opener_of(config: PortConfig, wait: bool) -> Callable[[], Link]:
    """Try to open the link now and answer what opens it; LinkError when waiting for it could not help, unless `wait`
    says to.

    A path that does not exist yet in a folder that does (a pseudo-terminal's name, a Unix socket) or an address where
    nobody listens yet will come with the antenna. A busy port, one without permission, a missing device node or an
    unknown interface is an error.
    """
    first: list[Link] = []
    try:
        first.append(open_link(config))
    except LinkError:
        if not (wait or comes_with_the_antenna(config)):
            raise

    def open_again() -> Link:
        return first.pop() if first else open_link(config)

    return open_again


def comes_with_the_antenna(config: PortConfig) -> bool:
    """Whether the port of a link that cannot be opened may appear when the antenna is started."""
    if isinstance(config, UnixLinkConfig):
        return config.path.parent.is_dir()
    if isinstance(config, SerialLinkConfig):
        return config.port.startswith("socket://") or _may_be_made(config.port)
    if isinstance(config, AdapterLinkConfig) and config.interface == "unix":
        return Path(str(config.channel)).parent.is_dir()
    return config.interface == "slcan" and _may_be_made(str(config.channel))


def _may_be_made(port: str) -> bool:
    path = Path(port)
    return not path.exists() and path.parent.is_dir() and _DEVICES not in path.absolute().parents
