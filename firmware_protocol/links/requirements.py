"""What a configured link has to be able to do, refused before it is opened."""

from __future__ import annotations

from firmware_protocol.bus_load import require_bus_carries, require_serial_carries
from firmware_protocol.errors import BadInputError
from firmware_protocol.links.config import AdapterLinkConfig, CanLinkConfig, LinkConfig, SerialLinkConfig


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
