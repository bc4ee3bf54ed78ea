"""Serial ports of this machine under the names that stay when a plug is moved."""

from __future__ import annotations

from pathlib import Path

_BY_ID = Path("/dev/serial/by-id")


def named_ports(folder: Path = _BY_ID) -> list[str]:
    """`port (name)` of each USB serial port, in the order of the names; empty where there is none."""
    try:
        names = sorted(folder.iterdir())
    except OSError:
        return []
    return [f"{name.resolve()} ({name})" for name in names]
