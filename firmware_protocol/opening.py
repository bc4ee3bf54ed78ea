"""From a configuration to an open link: to an antenna that speaks our frames, or to drives of another make."""

from __future__ import annotations

from firmware_protocol.links import (
    AdapterLinkConfig,
    CanLink,
    CanLinkConfig,
    CobsFraming,
    FaultyLink,
    Link,
    LinkConfig,
    MemoryLinkConfig,
    SerialLinkConfig,
    StreamLink,
    UnixLink,
    memory_pair,
    open_serial,
)


def open_link(config: LinkConfig) -> Link:
    """Open what a configuration names; LinkError with one clear line when that is missing, busy or refused.

    A memory link's other end is its attribute `peer` (with faults configured: make the pair with `memory_pair` and wrap
    one end).
    """
    link = _open(config)
    return link if config.faults is None else FaultyLink(link, config.faults)


def _open(config: LinkConfig) -> Link:
    if isinstance(config, AdapterLinkConfig):
        # an antenna of our own needs none of it
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
