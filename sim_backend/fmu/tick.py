"""The antenna's tick as a library: object code of the compiled kernel, linked with the shell in C."""

from __future__ import annotations

import hashlib
import os
import subprocess
from pathlib import Path

import numba

from firmware_protocol.errors import BadInputError
from firmware_protocol.kernel_cache import cache_directory, require_own, source_digest
from firmware_protocol.object_code import object_code
from sim_backend.c_compiler import c_compiler
from sim_backend.device import device_block_tick

SHELL = Path(__file__).with_name("shell.c")
_OPTIONS = ("-std=c11", "-O2", "-fPIC", "-shared", "-s", "-Wall", "-Wextra", "-Wconversion", "-Werror")
_TYPES = (numba.int64[::1], numba.int64, numba.int64)


def antenna_library() -> bytes:
    """Shared library with the functions of FMI: the same for every model, kept where compiled kernels are kept.

    BadInputError where there is no C compiler, or where it has something to say.
    """
    folder = cache_directory() / source_digest(__name__) / __name__
    require_own(folder.parent)
    folder.mkdir(parents=True, exist_ok=True)
    words = [c_compiler("an FMU"), *_OPTIONS]
    kept = folder / f"{hashlib.sha256(repr(words).encode() + SHELL.read_bytes()).hexdigest()[:16]}.so"
    if not kept.exists():
        made = folder / f"{kept.name}.{os.getpid()}"
        words += [str(SHELL), str(_tick_object(folder)), "-lm", "-o", str(made)]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode:
            raise BadInputError(str(SHELL), f"does not compile: {done.stderr.strip()[:400]}", "C11 without a warning")
        made.replace(kept)
    return kept.read_bytes()


def _tick_object(folder: Path) -> Path:
    kept = folder / "tick.o"
    if not kept.exists():
        made = folder / f"tick.{os.getpid()}"
        made.write_bytes(object_code(_tick, _TYPES, "gimbal_tick"))
        made.replace(kept)
    return kept


def _tick(words, x_size, received):  # type: ignore[no-untyped-def]  # its types are Numba's, see _TYPES
    return device_block_tick(words, x_size, received)
