"""Links: what carries blocks of frames between host and device. Public names of the folder."""

from firmware_protocol.links.can_bus import PythonCanBus
from firmware_protocol.links.can_errors import error_words, interface_problems, problems_of
from firmware_protocol.links.can_frame import CanFrame
from firmware_protocol.links.can_link import CanLink
from firmware_protocol.links.claims import BusClaim
from firmware_protocol.links.config import (
    AdapterLinkConfig,
    CanLinkConfig,
    DriveSection,
    LinkConfig,
    MemoryLinkConfig,
    SerialLinkConfig,
    UnixLinkConfig,
)
from firmware_protocol.links.descriptor import wait_readable
from firmware_protocol.links.faults import Cut, DirectionFaults, FaultsConfig, FaultyLink
from firmware_protocol.links.in_step import PATIENCE_S, AntennaInStep
from firmware_protocol.links.link import Link, LinkBasis, LinkLost, LinkState, LinkStatistics
from firmware_protocol.links.memory_link import MemoryLink, memory_pair
from firmware_protocol.links.pty_link import pty_link
from firmware_protocol.links.requirements import require_can_wait, require_known_interface, require_link_carries
from firmware_protocol.links.serial_names import named_ports
from firmware_protocol.links.serial_port import open_serial
from firmware_protocol.links.slcan_device import SlcanDevice
from firmware_protocol.links.stream_link import CobsFraming, Framing, StreamLink
from firmware_protocol.links.unix_link import UnixLink
from firmware_protocol.links.unix_socket import UnixListener, connected_to, unix_reason

__all__ = [
    "PATIENCE_S",
    "AdapterLinkConfig",
    "AntennaInStep",
    "BusClaim",
    "CanFrame",
    "CanLink",
    "CanLinkConfig",
    "CobsFraming",
    "Cut",
    "DirectionFaults",
    "DriveSection",
    "FaultsConfig",
    "FaultyLink",
    "Framing",
    "Link",
    "LinkBasis",
    "LinkConfig",
    "LinkLost",
    "LinkState",
    "LinkStatistics",
    "MemoryLink",
    "MemoryLinkConfig",
    "PythonCanBus",
    "SerialLinkConfig",
    "SlcanDevice",
    "StreamLink",
    "UnixLink",
    "UnixLinkConfig",
    "UnixListener",
    "connected_to",
    "error_words",
    "interface_problems",
    "memory_pair",
    "named_ports",
    "open_serial",
    "problems_of",
    "pty_link",
    "require_can_wait",
    "require_known_interface",
    "require_link_carries",
    "unix_reason",
    "wait_readable",
]
