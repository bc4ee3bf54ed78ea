"""The C compiler of this machine."""

from __future__ import annotations

import os
import shutil

from firmware_protocol.errors import BadInputError


def c_compiler(wanted_for: str) -> str:
    """$CC, else cc or gcc; BadInputError, which says what it is wanted for, where there is none."""
    named = os.environ.get("CC")
    compiler = shutil.which(named) if named else shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        found = f"needs a C compiler, and CC={named} is none" if named else "needs a C compiler, and there is none"
        raise BadInputError(wanted_for, found, "gcc or clang, or CC")
    return compiler
