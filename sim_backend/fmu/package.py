"""A model as an FMU: library, description and the antenna's words in one archive."""

from __future__ import annotations

import hashlib
import io
import platform
import struct
import zipfile

import numpy as np

from firmware_protocol.receiver import CRC_ERRORS, OUT_OF_RANGE
from sim_backend.device import ANSWER_AT, DEVICE_OCTETS, DRIVE, Device
from sim_backend.fmu.description import IDENTIFIER, manifest, model_description, terminals
from sim_backend.fmu.tick import antenna_library
from sim_backend.layout import APPLIED, POSITION, RATE, SEED, TEMPERATURE
from sim_backend.model import AntennaModel

_TOKEN_SIZE = 40
#: an archive of the same model has the same bytes
_WHEN = (1980, 1, 1, 0, 0, 0)


def fmu_of(model: AntennaModel, rate_hz: float = 1000.0, made_by: str = "gimbal-hil") -> bytes:
    """The archive: FMI 3.0 co-simulation of the virtual antenna with its firmware, for this system and architecture.

    A tick is 1 / rate_hz; the seed of the noise is a parameter of the FMU. Frames go over FMI-LS-BUS.
    """
    device, library = Device(model, rate_hz=rate_hz), antenna_library()
    words = device.words.astype("<i8").tobytes()
    token = hashlib.sha256(words + library).hexdigest()[: _TOKEN_SIZE - 1]
    folder = f"binaries/{platform.machine()}-{platform.system().lower()}"
    files = {
        "modelDescription.xml": model_description(model, token, rate_hz, made_by).encode(),
        "terminalsAndIcons/terminalsAndIcons.xml": terminals().encode(),
        "extra/org.fmi-standard.fmi-ls-bus/fmi-ls-manifest.xml": manifest().encode(),
        "resources/antenna.bin": _layout_of(device, token, rate_hz) + words,
        "documentation/model.yaml": model.to_yaml().encode(),
        f"{folder}/{IDENTIFIER}.so": library,
    }
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as written:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, _WHEN)
            entry.compress_type = zipfile.ZIP_DEFLATED
            written.writestr(entry, content)
    return archive.getvalue()


def _layout_of(device: Device, token: str, rate_hz: float) -> bytes:
    """`struct layout` of shell.c."""
    state, k = _place(device, device.X), _place(device, device.K)
    return struct.pack(
        f"<{_TOKEN_SIZE}sd19q",
        token.encode(),
        rate_hz,
        len(device.words),
        device.x_size,
        len(device.model.axes),
        DEVICE_OCTETS[0],
        state,
        ANSWER_AT,
        ANSWER_AT,
        k + SEED,
        _place_in_drive("state"),
        _place_in_drive("fault"),
        _place(device, device.receivers),
        *device.receivers.shape,
        CRC_ERRORS,
        OUT_OF_RANGE,
        POSITION,
        RATE,
        APPLIED,
        TEMPERATURE,
    )


def _place(device: Device, part: np.ndarray) -> int:
    """Which of a device's words is the first of a part."""
    return int(part.ctypes.data - device.words.ctypes.data) // 8


def _place_in_drive(field: str) -> int:
    assert DRIVE.fields is not None
    return int(DRIVE.fields[field][1]) // 8
