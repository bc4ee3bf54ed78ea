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

    kind: Literal["can"] = Field(description="which kind of link this is")
    interface: str = Field(description="python-can's name of the interface: socketcan, slcan, virtual, pcan, ...")
    channel: str | int = Field(description="can0, a serial port for slcan, a number, ...")
    bitrate: int = Field(default=1_000_000, gt=0, description="bit/s")
    options: dict[str, str | int | float | bool] = Field(
        default_factory=dict, description="handed to python-can as they are"
    )


class SerialLinkConfig(_LinkConfig):
    """A serial port, pseudo-terminal or TCP socket with COBS packets."""

    kind: Literal["serial"] = Field(description="which kind of link this is")
    port: str = Field(min_length=1, description="device path, pseudo-terminal or socket://host:port")
    baudrate: int = Field(default=921_600, gt=0, description="bit/s; without meaning for a pseudo-terminal or socket")


class UnixLinkConfig(_LinkConfig):
    """A Unix socket of the packet kind."""

    kind: Literal["unix"] = Field(description="which kind of link this is")
    path: Path = Field(description="of the socket")
    listen: bool = Field(default=False, description="whether this end makes the socket and waits for the other")


class DriveSection(Strict):
    """One drive of an adapter link, the carrying axis first."""

    id: int = Field(ge=0, le=127, description="of the drive on the bus: moteus id, ODrive node_id, CANopen node")
    torque_nm: float = Field(gt=0.0, le=1e6, description="largest torque at the joint, N m")
    sign: Literal[-1, 1] = Field(default=1, description="-1 where the drive turns the other way")
    gear: float = Field(default=1.0, gt=0.0, description="turns of the drive's shaft for one turn of the joint")
    zero_rad: float = Field(default=0.0, description="the joint's position where the drive reads zero, rad")
    counts_per_turn: float | None = Field(default=None, gt=0.0, description="CiA 402: increments a turn of the shaft")
    rated_torque_nm: float | None = Field(default=None, gt=0.0, description="CiA 402: object 0x6076, N m")
    map: Path | None = Field(default=None, description="dbc: the YAML file that maps the drive's DBC")


class AdapterLinkConfig(_LinkConfig):
    """Two drives of another make behind the antenna's frames."""

    kind: Literal["adapter"] = Field(description="which kind of link this is")
    drive: str = Field(description="moteus, odrive, cia402, dbc, or a plug-in's name")
    interface: str = Field(description="python-can's name of the interface, or unix for simulated drives")
    channel: str | int = Field(description="can0, a number, or the path of the socket")
    bitrate: int = Field(default=1_000_000, gt=0, description="bit/s")
    data_bitrate: int | None = Field(default=None, gt=0, description="bit/s of CAN FD; classic CAN without it")
    options: dict[str, str | int | float | bool] = Field(
        default_factory=dict, description="handed to python-can as they are"
    )
    name: str = Field(default="adapter", min_length=1, description="what the antenna is called towards the host")
    rate_hz: float = Field(default=1000.0, ge=10.0, le=20000.0, description="left out: that of the configuration")
    watchdog_s: float = Field(
        default=0.02, gt=0.0, le=10.0, description="a set-point is valid so long at the drive; left out: the deadman's"
    )
    drives: Annotated[tuple[DriveSection, ...], Field(min_length=2, max_length=2)] = Field(
        description="both drives, the carrying axis first"
    )


class MemoryLinkConfig(_LinkConfig):
    """The virtual antenna in the same process."""

    kind: Literal["memory"] = Field(description="which kind of link this is")


LinkConfig = Annotated[
    CanLinkConfig | SerialLinkConfig | UnixLinkConfig | AdapterLinkConfig | MemoryLinkConfig,
    Field(discriminator="kind"),
]
