"""From a configuration to an open link."""

from __future__ import annotations

from firmware_protocol.bus_load import require_bus_carries, require_serial_carries
from firmware_protocol.errors import BadInputError
from firmware_protocol.links.can_link import CanLink
from firmware_protocol.links.config import (
    AdapterLinkConfig,
    CanLinkConfig,
    LinkConfig,
    MemoryLinkConfig,
    SerialLinkConfig,
)
from firmware_protocol.links.faults import FaultyLink
from firmware_protocol.links.link import Link
from firmware_protocol.links.memory_link import memory_pair
from firmware_protocol.links.serial_port import open_serial
from firmware_protocol.links.stream_link import CobsFraming, StreamLink
from firmware_protocol.links.unix_link import UnixLink


def open_link(config: LinkConfig) -> Link:
    """Open what a configuration names; LinkError with one clear line when that is missing, busy or refused.

    A memory link's other end is its attribute `peer` (with faults configured: make the pair with `memory_pair` and wrap
    one end).
    """
    link = _open(config)
    return link if config.faults is None else FaultyLink(link, config.faults)


def require_link_carries(config: LinkConfig, rate_hz: float, where: str) -> None:
    """Refuse (BadInputError at `where`) a tick rate that the configured bus or line cannot carry."""
    if isinstance(config, CanLinkConfig):
        require_bus_carries(rate_hz, config.bitrate, where)
    elif isinstance(config, SerialLinkConfig):
        require_serial_carries(rate_hz, config.baudrate, where)


def require_known_interface(config: LinkConfig) -> None:
    """Refuse (BadInputError) an interface that this machine's python-can does not know."""
    if not isinstance(config, CanLinkConfig | AdapterLinkConfig):
        return
    from can.interfaces import VALID_INTERFACES

    own = {"unix"} if isinstance(config, AdapterLinkConfig) else set()
    known = sorted(own | VALID_INTERFACES)
    if config.interface not in known:
        raise BadInputError("link.interface", f"no interface {config.interface!r}", ", ".join(known))


def require_can_wait(config: LinkConfig) -> None:
    """Refuse (BadInputError) a link whose antenna cannot be in lockstep with its host."""
    if isinstance(config, AdapterLinkConfig):
        raise BadInputError("--lockstep", "drives of another make have clocks of their own", "a link to an antenna")
    if config.faults is not None:
        raise BadInputError("--lockstep: link.faults", "a lost frame would stop the time of both", "no faults")


def _open(config: LinkConfig) -> Link:
    if isinstance(config, AdapterLinkConfig):
        # here, because it stands on the links
        from firmware_protocol.adapters import AdapterLink

        return AdapterLink(config)
    if isinstance(config, CanLinkConfig):
        return CanLink(config.interface, config.channel, config.bitrate, config.options)
    if isinstance(config, SerialLinkConfig):
        port, baudrate = config.port, config.baudrate
        return StreamLink(f"serial {port}", lambda: open_serial(port, baudrate), CobsFraming())
    if isinstance(config, MemoryLinkConfig):
        return memory_pair()[0]
    return UnixLink(config.path, config.listen)
