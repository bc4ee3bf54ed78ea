"""The configuration that comes with the package."""

from __future__ import annotations

from pathlib import Path

from gimbal_hil.loop.settings.daemon import DaemonSettings, load_settings
from sim_backend.shipped import shipped_file


def shipped_settings_path(name: str = "virtual_antenna") -> Path:
    """Path of a shipped configuration file."""
    return shipped_file(f"{name}.yaml")


def shipped_settings(name: str = "virtual_antenna") -> DaemonSettings:
    """A shipped configuration; `virtual_antenna` is used where no --config is given."""
    return load_settings(shipped_settings_path(name))
