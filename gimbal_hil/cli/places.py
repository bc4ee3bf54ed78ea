"""Where a command may leave its files: asked before its work begins."""

from __future__ import annotations

import os
from pathlib import Path


def require_new(folder: Path, force: bool, *names: str) -> None:
    """BadInputError for a folder that can be neither made nor written to, and, unless `force`, for files of these names
    that it holds already.
    """
    from firmware_protocol.errors import BadInputError

    for name in names:
        if (folder / name).exists() and not force:
            raise BadInputError(str(folder / name), "already exists", "a new folder, or --force to overwrite it")
    nearest = next(place for place in (folder.absolute(), *folder.absolute().parents) if place.exists())
    if not nearest.is_dir():
        raise BadInputError(str(folder), f"{nearest} is a file", "a folder that can be written to")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise BadInputError(str(folder), f"nothing may be written in {nearest}", "a folder that can be written to")
