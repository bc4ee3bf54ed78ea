"""The C device of `firmware_protocol/c`, run here with the plant behind it: as a library of this process, or as machine
code of a microcontroller.
"""

from sim_backend.firmware.antenna import FirmwareAntenna, LibraryAntenna, fill_settings
from sim_backend.firmware.board import BoardAntenna, BoardImage, build_board
from sim_backend.firmware.handing_over import SETTINGS_FILE, device_files, write_device
from sim_backend.firmware.library import (
    DEVICE_SOURCES,
    PROTOCOL_FOLDER,
    SOURCE_FOLDER,
    WARNINGS,
    BenchLibrary,
    build_library,
    firmware_sources,
)
from sim_backend.firmware.machine import MachineAntenna, MachineImage, build_image
from sim_backend.firmware.running import close_firmware, run_firmware
from sim_backend.firmware.structures import HostBench, SmallBench

__all__ = [
    "DEVICE_SOURCES",
    "PROTOCOL_FOLDER",
    "SETTINGS_FILE",
    "SOURCE_FOLDER",
    "WARNINGS",
    "BenchLibrary",
    "BoardAntenna",
    "BoardImage",
    "FirmwareAntenna",
    "HostBench",
    "LibraryAntenna",
    "MachineAntenna",
    "MachineImage",
    "SmallBench",
    "build_board",
    "build_image",
    "build_library",
    "close_firmware",
    "device_files",
    "fill_settings",
    "firmware_sources",
    "run_firmware",
    "write_device",
]
