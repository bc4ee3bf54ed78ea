"""The C device as a library of this process: built with the machine's C compiler, called through ctypes."""

from __future__ import annotations

import ctypes
import hashlib
import os
import subprocess
from collections.abc import Mapping
from pathlib import Path

import firmware_protocol
from firmware_protocol.errors import BadInputError
from sim_backend.c_compiler import c_compiler
from sim_backend.firmware.structures import HostBench

PROTOCOL_FOLDER = Path(firmware_protocol.__file__).parent
SOURCE_FOLDER = PROTOCOL_FOLDER / "c"
#: the device itself, without the bench
DEVICE_SOURCES = ("gimbal_device.c", "gimbal_drive.c", "gimbal_guards.c", "gimbal_stopping.c", "gimbal_stream.c")
SOURCES = (*DEVICE_SOURCES, "gimbal_bench.c")
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Werror")


def firmware_sources(changed: Mapping[str, str] | None = None) -> dict[str, str]:
    """Text of every source and header by file name; `changed` goes in place of those of the same name."""
    files = [PROTOCOL_FOLDER / "gimbal_protocol.h", *sorted(SOURCE_FOLDER.glob("*.[ch]"))]
    return {file.name: file.read_text(encoding="utf-8") for file in files} | dict(changed or {})


def build_library(folder: Path, changed: Mapping[str, str] | None = None, optimise: str = "-O2") -> Path:
    """Compile the device with its bench into `folder`; answers the library's path, which names its content.

    BadInputError where there is no C compiler ($CC, else cc or gcc), or where it has something to say; of changed
    sources it may warn.
    """
    compiler = c_compiler("the C device")
    sources = firmware_sources(changed)
    name = hashlib.sha256(repr((sorted(sources.items()), optimise, compiler)).encode()).hexdigest()[:16]
    library = folder / f"gimbal-{name}.so"
    if library.exists():
        return library
    place = folder / name
    place.mkdir(parents=True, exist_ok=True)
    for file, text in sources.items():
        (place / file).write_text(text, encoding="utf-8")
    warnings = ["-w"] if changed else WARNINGS
    words = [compiler, "-std=c11", optimise, "-fPIC", "-shared", *warnings, *SOURCES, "-o", f"{library}.{os.getpid()}"]
    done = subprocess.run(words, cwd=place, capture_output=True, text=True, check=False)
    if done.returncode:
        raise BadInputError(str(place), f"does not compile: {done.stderr.strip()[:400]}", "C11 without a warning")
    Path(f"{library}.{os.getpid()}").replace(library)
    return library


class BenchLibrary:
    """The functions of a built library."""

    def __init__(self, path: Path) -> None:
        self._library = ctypes.CDLL(str(path))
        bench = ctypes.POINTER(HostBench)
        self.start = self._function("gimbal_bench_start", None, bench)
        self.tick = self._function("gimbal_bench_tick", None, bench, ctypes.c_char_p, ctypes.c_uint32)
        self.line_tick = self._function(
            "gimbal_bench_line_tick", ctypes.c_uint32, bench, ctypes.c_char_p, ctypes.c_uint32
        )
        size = int(self._function("gimbal_bench_size", ctypes.c_uint32)())
        if size != ctypes.sizeof(HostBench):
            raise BadInputError(str(path), f"has a bench of {size} bytes", f"{ctypes.sizeof(HostBench)}, as known here")

    def _function(self, name: str, answer: type | None, *arguments: type) -> ctypes._NamedFuncPointer:
        function = getattr(self._library, name)
        function.restype, function.argtypes = answer, arguments
        return function
