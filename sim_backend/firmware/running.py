"""A virtual antenna with the firmware that is wanted."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

from sim_backend.device import Device
from sim_backend.firmware.antenna import FirmwareAntenna, LibraryAntenna
from sim_backend.firmware.board import BoardAntenna, BoardImage, build_board
from sim_backend.firmware.library import BenchLibrary, build_library
from sim_backend.firmware.machine import MachineAntenna, MachineImage, build_image
from sim_backend.firmware_run import FirmwareRun
from sim_backend.model import AntennaModel


@cache
def _library() -> BenchLibrary:
    # a library that is loaded needs its file no more
    with tempfile.TemporaryDirectory() as folder:
        return BenchLibrary(build_library(Path(folder)))


@cache
def _image() -> MachineImage:
    with tempfile.TemporaryDirectory() as folder:
        return build_image(Path(folder))


@cache
def _board() -> BoardImage:
    with tempfile.TemporaryDirectory() as folder:
        return build_board(Path(folder))


def run_firmware(how: FirmwareRun, model: AntennaModel, rate_hz: float, seed: int) -> Device:
    """The plant of a model with this firmware before it, built first; BadInputError where a tool for it is missing."""
    if how is FirmwareRun.VIRTUAL:
        return Device(model, rate_hz=rate_hz, seed=seed)
    if how is FirmwareRun.BOARD:
        return BoardAntenna(_board(), model, rate_hz=rate_hz, seed=seed)
    if how is FirmwareRun.LIBRARY:
        return LibraryAntenna(_library(), model, rate_hz=rate_hz, seed=seed)
    return MachineAntenna(_image(), model, rate_hz=rate_hz, seed=seed)


def close_firmware(device: Device) -> None:
    """Give back what the firmware of an antenna runs on."""
    if isinstance(device, FirmwareAntenna):
        device.close()
