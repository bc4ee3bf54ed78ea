"""The antenna's tick as object code."""

from __future__ import annotations

import os
from pathlib import Path

import numba

from firmware_protocol.object_code import object_code
from sim_backend.device import device_block_tick

_TYPES = (numba.int64[::1], numba.int64, numba.int64)


def tick_object(folder: Path) -> Path:
    """`gimbal_tick` of shell.c as an object file in a folder, where it stays."""
    kept = folder / "tick.o"
    if not kept.exists():
        made = folder / f"tick.{os.getpid()}"
        made.write_bytes(object_code(_tick, _TYPES, "gimbal_tick"))
        made.replace(kept)
    return kept


def _tick(words, x_size, received):  # type: ignore[no-untyped-def]  # its types are Numba's
    return device_block_tick(words, x_size, received)
