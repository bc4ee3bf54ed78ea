"""The C device for somebody's own controller: its sources, and the settings of his antenna as a header."""

from __future__ import annotations

import ctypes
from pathlib import Path

from firmware_protocol.errors import BadInputError
from sim_backend.device import Device
from sim_backend.firmware.antenna import fill_settings
from sim_backend.firmware.library import DEVICE_SOURCES, firmware_sources
from sim_backend.firmware.structures import CSettings
from sim_backend.model import AntennaModel

SETTINGS_FILE = "gimbal_settings.h"
_HEADERS = ("gimbal_protocol.h", "gimbal_device.h", "gimbal_parts.h", "gimbal_stream.h")
_ENDS = {-(1 << 31): "INT32_MIN", (1 << 31) - 1: "INT32_MAX"}


def device_files(model: AntennaModel, rate_hz: float) -> dict[str, str]:
    """Sources and headers of the device by file name, without the bench, and the settings of this antenna."""
    sources = firmware_sources()
    kept = {name: sources[name] for name in (*_HEADERS, *DEVICE_SOURCES)}
    return kept | {SETTINGS_FILE: settings_header(model, rate_hz)}


def settings_header(model: AntennaModel, rate_hz: float) -> str:
    """The settings that the virtual antenna of this model has at this rate, as a C header: every field by its name."""
    settings = CSettings()
    fill_settings(settings, Device(model, rate_hz=rate_hz).drive, len(model.axes))
    own = _fields(settings, "    ")
    joints = ",\n".join("        {\n" + _fields(joint, "            ") + "        }" for joint in settings.joints)
    name = model.name.replace("*/", "* /")
    return (
        f"/* Settings of the antenna {name} at {rate_hz:g} ticks a second, in raw integers.\n"
        " * gimbal_device.h says what each is. Made by gimbal-hil protocol --device.\n */\n"
        "#ifndef GIMBAL_SETTINGS_H\n#define GIMBAL_SETTINGS_H\n\n"
        '#include "gimbal_device.h"\n\n'
        f"static const gimbal_settings_t gimbal_settings = {{\n{own}    .joints = {{\n{joints}\n    }},\n}};\n\n"
        "#endif\n"
    )


def write_device(folder: Path, model: AntennaModel, rate_hz: float, *, force: bool = False) -> list[Path]:
    """Write `device_files` into a folder; answers their paths. BadInputError where a file is there and differs."""
    files = {folder / name: text for name, text in device_files(model, rate_hz).items()}
    for path, text in files.items():
        if path.exists() and not force and path.read_text(encoding="utf-8") != text:
            raise BadInputError(str(path), "the file exists and differs", "another folder, or --force")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for path, text in files.items():
            path.write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise BadInputError(str(folder), error.strerror or str(error), "a folder that can be written to") from error
    return list(files)


def _fields(record: ctypes.Structure, indent: str) -> str:
    lines = []
    for name, kind, *_ in record._fields_:
        if not issubclass(kind, ctypes.Array):
            value = int(getattr(record, name))
            lines.append(f"{indent}.{name} = {_ENDS.get(value, value)},\n")
    return "".join(lines)
