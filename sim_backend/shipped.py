"""Where the shipped configuration lies, in a checkout and in an installed package alike."""

from __future__ import annotations

from pathlib import Path

_ROOT = Path(__file__).resolve().parent.parent


def shipped_file(*parts: str) -> Path:
    """Path of a file of the shipped configuration, e.g. ("models", "thesis.yaml")."""
    installed = _ROOT / "gimbal_hil" / "config"
    return (installed if installed.is_dir() else _ROOT / "config").joinpath(*parts)
