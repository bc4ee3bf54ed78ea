"""The C device by name: how it is run, for commands that take one in place of the virtual antenna's own firmware."""

from __future__ import annotations

import tempfile
from enum import Enum
from pathlib import Path

from sim_backend.firmware.antenna import FirmwareAntenna, LibraryAntenna
from sim_backend.firmware.library import BenchLibrary, build_library
from sim_backend.firmware.machine import MachineAntenna, build_image
from sim_backend.model import AntennaModel


class FirmwareRun(Enum):
    """How the C device is run in this process."""

    #: a library of this machine
    LIBRARY = "c"
    #: Cortex-M4 machine code in an emulator
    MACHINE_CODE = "cortex-m"


def run_firmware(how: FirmwareRun, model: AntennaModel, rate_hz: float, seed: int) -> FirmwareAntenna:
    """Build the C device and put the plant of a model behind it; BadInputError where a compiler is missing."""
    with tempfile.TemporaryDirectory() as folder:
        if how is FirmwareRun.LIBRARY:
            # a library that is loaded needs its file no more
            library = BenchLibrary(build_library(Path(folder)))
            return LibraryAntenna(library, model, rate_hz=rate_hz, seed=seed)
        return MachineAntenna(build_image(Path(folder)), model, rate_hz=rate_hz, seed=seed)
