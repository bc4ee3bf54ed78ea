"""Which link: the `link` section of a configuration file, one shape for each kind."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from firmware_protocol.documents import Strict
from firmware_protocol.links.faults import FaultsConfig


class _LinkConfig(Strict):
    """What every link may have."""

    faults: FaultsConfig | None = Field(
        default=None, description="faults to put into the link, for tests and demonstrations"
    )


class CanLinkConfig(_LinkConfig):
    """A CAN bus through python-can."""

    kind: Literal["can"]
    interface: str = Field(description="python-can's name of the interface: socketcan, slcan, virtual, pcan, ...")
    channel: str | int = Field(description="can0, a serial port for slcan, a number, ...")
    bitrate: int = Field(default=1_000_000, gt=0, description="bit/s")
    options: dict[str, str | int | float | bool] = Field(
        default_factory=dict, description="handed to python-can as they are"
    )


class SerialLinkConfig(_LinkConfig):
    """A serial port, pseudo-terminal or TCP socket with COBS packets."""

    kind: Literal["serial"]
    port: str = Field(min_length=1, description="device path, pseudo-terminal or socket://host:port")
    baudrate: int = Field(default=921_600, gt=0, description="bit/s; without meaning for a pseudo-terminal or socket")


class UnixLinkConfig(_LinkConfig):
    """A Unix socket of the packet kind."""

    kind: Literal["unix"]
    path: Path
    listen: bool = Field(default=False, description="whether this end makes the socket and waits for the other")


class MemoryLinkConfig(_LinkConfig):
    """The virtual antenna in the same process."""

    kind: Literal["memory"]


LinkConfig = Annotated[
    CanLinkConfig | SerialLinkConfig | UnixLinkConfig | MemoryLinkConfig, Field(discriminator="kind")
]
