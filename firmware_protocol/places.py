"""Where files may be left: asked before the work for them begins."""

from __future__ import annotations

import os
from pathlib import Path

from firmware_protocol.errors import BadInputError

_WRITABLE = "a folder that can be written to"


def require_new(folder: Path, force: bool, *names: str, instead: str = "a new folder") -> None:
    """BadInputError for a folder that can be neither made nor written to, and, unless `force`, for files of these names
    that it holds already; `instead` is what would do without force.

    A link counts as what lies there, wherever it leads.
    """
    nearest = next(place for place in (folder.absolute(), *folder.absolute().parents) if os.path.lexists(place))
    if not os.path.isdir(nearest):
        what = "a link that leads to no folder" if nearest.is_symlink() else "a file"
        raise BadInputError(str(folder), f"{nearest} is {what}", _WRITABLE)
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise BadInputError(str(folder), f"nothing may be written in {nearest}", _WRITABLE)
    there = next((folder / name for name in names if os.path.lexists(folder / name)), None)
    if there is not None and not force:
        raise BadInputError(str(there), "already exists", f"{instead}, or --force to overwrite it")
