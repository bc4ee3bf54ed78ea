"""Other drives behind the antenna's frames: their messages become the signals of an axis, and back."""

from firmware_protocol.adapters.adapter_link import AdapterLink
from firmware_protocol.adapters.bus import Bus, UnixCanBus, open_bus
from firmware_protocol.adapters.cia402 import Cia402Drive
from firmware_protocol.adapters.dbc_map import DriveMap, load_map
from firmware_protocol.adapters.drive import (
    AxisSample,
    DriveTiming,
    ForeignDrive,
    Gives,
    Power,
    ShortsWindings,
    StopsUnfed,
    missing_text,
    on_the_joint,
)
from firmware_protocol.adapters.gateway import Gateway, torque_exponent
from firmware_protocol.adapters.mapped import MappedDrive
from firmware_protocol.adapters.moteus import MoteusDrive
from firmware_protocol.adapters.odrive import OdriveDrive
from firmware_protocol.adapters.registry import DRIVES, GROUP, drive_named, gives_of, require_drives
from firmware_protocol.adapters.spoken import (
    DriveReport,
    ListenedBus,
    NamesItsWords,
    Spoken,
    drive_reports,
    probes,
    strangers,
)
from firmware_protocol.links import CanFrame, PythonCanBus

__all__ = [
    "DRIVES",
    "GROUP",
    "AdapterLink",
    "AxisSample",
    "Bus",
    "CanFrame",
    "Cia402Drive",
    "DriveMap",
    "DriveReport",
    "DriveTiming",
    "ForeignDrive",
    "Gateway",
    "Gives",
    "ListenedBus",
    "MappedDrive",
    "MoteusDrive",
    "NamesItsWords",
    "OdriveDrive",
    "Power",
    "PythonCanBus",
    "ShortsWindings",
    "Spoken",
    "StopsUnfed",
    "UnixCanBus",
    "drive_named",
    "drive_reports",
    "gives_of",
    "load_map",
    "missing_text",
    "on_the_joint",
    "open_bus",
    "probes",
    "require_drives",
    "strangers",
    "torque_exponent",
]
