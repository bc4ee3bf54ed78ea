"""The C compiler of this machine."""

from __future__ import annotations

import os
import shutil

from firmware_protocol.errors import BadInputError


def c_compiler(wanted_for: str) -> str:
    """$CC, else cc or gcc; BadInputError, which says what it is wanted for, where there is none."""
    compiler = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        raise BadInputError(wanted_for, "needs a C compiler, and there is none", "gcc or clang, or CC")
    return compiler
