"""Does the antenna answer? Opens the configured link, listens for a moment, and says what came."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeGuard

from firmware_protocol.bus_load import bus_load
from firmware_protocol.errors import LinkError
from firmware_protocol.links import (
    AdapterLinkConfig,
    CanLinkConfig,
    LinkConfig,
    SerialLinkConfig,
    interface_problems,
    named_ports,
)
from firmware_protocol.opening import open_link
from firmware_protocol.schema import BY_CAN_ID, RECORD_SIZE
from gimbal_hil.loop.settings import DaemonSettings, EmbeddedAntenna

if TYPE_CHECKING:
    from firmware_protocol.adapters import DriveReport
    from gimbal_hil.realtime.daemon.drive_check import DriveListener

_LISTEN_S = 1.0


@dataclass(slots=True)
class LinkReport:
    """What stood on the link; `reasons` speak against using it, `remarks` do not."""

    name: str
    frames: dict[str, int] = field(default_factory=dict)
    bus_load: float | None = None
    reasons: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    #: of other makes, each as it was heard
    drives: list[DriveReport] = field(default_factory=list)
    #: whether there is a link to listen on
    listens: bool = True

    @property
    def good(self) -> bool:
        """Whether nothing speaks against it."""
        return not self.reasons

    def as_dict(self) -> dict[str, object]:
        """For JSON."""
        return {
            "link": self.name,
            "good": self.good,
            "frames_heard": self.frames,
            "computed_bus_load": self.bus_load,
            "drives": [drive.as_dict() for drive in self.drives],
            "reasons": self.reasons,
            "remarks": self.remarks,
        }

    def lines(self) -> list[str]:
        """For people."""
        if not self.listens:
            return [f"link: {self.name}"]
        heard = (
            f"{sum(self.frames.values())} frames of {len(self.frames)} kinds heard"
            if self.frames
            else "no frames heard"
        )
        load = "" if self.bus_load is None else f", computed bus load {self.bus_load:.0%}"
        drives = [drive.line for drive in self.drives]
        return [f"link: {self.name}: {heard}{load}", *drives, *(f"remark: {remark}" for remark in self.remarks)]


def check_link(settings: DaemonSettings) -> LinkReport:
    """Listen without commanding: an antenna that is powered sends its feedback by itself. An slcan adapter is told to
    open its channel, drives that speak only when asked are asked; a port in use is left alone.
    """
    config = settings.link
    if isinstance(config, EmbeddedAntenna):
        name = f"none needed: the virtual antenna {config.embedded.model} runs in this process"
        return LinkReport(name, listens=False)
    report = LinkReport(str(config.kind))
    if isinstance(config, AdapterLinkConfig):
        report.remarks += _not_given(config)
    if isinstance(config, CanLinkConfig):
        report.bus_load = bus_load(settings.rate_hz, config.bitrate)
    if _is_socketcan(config):
        report.reasons += interface_problems(str(config.channel), config.bitrate)
    if ports := _serial_ports(config):
        report.remarks.append(f"serial ports: {', '.join(ports)}")
    listener: DriveListener | None = None
    try:
        if isinstance(config, AdapterLinkConfig):
            from gimbal_hil.realtime.daemon.drive_check import DriveListener

            listener = DriveListener(config)
        link = open_link(config) if listener is None else listener.link
    except LinkError as error:
        report.reasons.append(str(error))
        return report
    report.name = link.name
    try:
        end = time.monotonic() + _LISTEN_S
        while time.monotonic() < end:
            link.wait(10_000_000)
            _count(link.receive(), report.frames)
        if listener is not None:
            heard = listener.judged()
            report.drives = heard.drives
            report.reasons += heard.reasons
            report.remarks += heard.remarks
    finally:
        link.close()
    if link.loss is not None:
        report.reasons.append(str(link.loss))
    elif not report.frames and not report.reasons:
        report.reasons.append(f"{link.name} is open, but no antenna answered within {_LISTEN_S:g} s")
    if link.statistics.malformed:
        report.remarks.append(f"{link.statistics.malformed} packets were not whole frames")
    return report


def _is_socketcan(config: LinkConfig) -> TypeGuard[CanLinkConfig | AdapterLinkConfig]:
    return isinstance(config, CanLinkConfig | AdapterLinkConfig) and config.interface == "socketcan"


def _serial_ports(config: LinkConfig) -> list[str]:
    """Those that there are, where the link is behind one."""
    slcan = isinstance(config, CanLinkConfig | AdapterLinkConfig) and config.interface == "slcan"
    return named_ports() if slcan or isinstance(config, SerialLinkConfig) else []


def _not_given(config: AdapterLinkConfig) -> list[str]:
    """What the drives do not tell, and which guards are absent because of it."""
    from firmware_protocol.adapters import gives_of, missing_text

    found = [gives_of(config.drive, section) for section in config.drives]
    return missing_text(frozenset.intersection(*found))


def _count(block: bytes, frames: dict[str, int]) -> None:
    for at in range(0, len(block), RECORD_SIZE):
        identifier = int.from_bytes(block[at : at + 2], "little")
        message = BY_CAN_ID.get(identifier)
        name = message.name if message else f"0x{identifier:03x}"
        frames[name] = frames.get(name, 0) + 1
