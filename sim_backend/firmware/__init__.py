"""The C device of `firmware_protocol/c`, run here: as a library of this process, with the plant behind it."""

from sim_backend.firmware.antenna import FirmwareAntenna, LibraryAntenna, fill_settings
from sim_backend.firmware.library import (
    DEVICE_SOURCES,
    PROTOCOL_FOLDER,
    SOURCE_FOLDER,
    WARNINGS,
    BenchLibrary,
    build_library,
    firmware_sources,
)
from sim_backend.firmware.structures import HostBench, SmallBench

__all__ = [
    "DEVICE_SOURCES",
    "PROTOCOL_FOLDER",
    "SOURCE_FOLDER",
    "WARNINGS",
    "BenchLibrary",
    "FirmwareAntenna",
    "HostBench",
    "LibraryAntenna",
    "SmallBench",
    "build_library",
    "fill_settings",
    "firmware_sources",
]
