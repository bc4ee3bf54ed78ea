"""The antenna's tick as a library: object code of the compiled kernel, linked with the shell in C."""

from __future__ import annotations

import hashlib
import os
import subprocess
from pathlib import Path

from firmware_protocol.errors import BadInputError
from firmware_protocol.kernel_cache import cache_directory, require_own, source_digest
from sim_backend.c_compiler import c_compiler
from sim_backend.fmu.kernel import tick_object

SHELL = Path(__file__).with_name("shell.c")
_OPTIONS = ("-std=c11", "-O2", "-fPIC", "-shared", "-s", "-Wl,-z,defs", "-Wall", "-Wextra", "-Wconversion", "-Werror")


def antenna_library() -> bytes:
    """Shared library with the functions of FMI: the same for every model, kept where compiled kernels are kept.

    BadInputError where there is no C compiler, or where it has something to say.
    """
    kept = _library()
    if not kept.exists():
        made = kept.with_suffix(f".{os.getpid()}")
        words = [*_compiler(), str(SHELL), str(tick_object(kept.parent)), "-lm", "-o", str(made)]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode:
            raise BadInputError(str(SHELL), f"does not compile: {done.stderr.strip()[:400]}", "C11 without a warning")
        made.replace(kept)
    return kept.read_bytes()


def library_is_kept() -> bool:
    """Whether `antenna_library` has nothing to translate, which takes a minute."""
    return _library().exists()


def _library() -> Path:
    """Where the library of these sources is kept, in a folder that is there."""
    # of the kernel's sources alone: what is around it changes without translating it anew
    folder = cache_directory() / source_digest("sim_backend.fmu.kernel") / __name__
    require_own(folder.parent)
    folder.mkdir(parents=True, exist_ok=True)
    return folder / f"{hashlib.sha256(repr(_compiler()).encode() + SHELL.read_bytes()).hexdigest()[:16]}.so"


def _compiler() -> list[str]:
    return [c_compiler("an FMU"), *_OPTIONS]
