"""The models that come with the package."""

from __future__ import annotations

from pathlib import Path

from sim_backend.model.model import AntennaModel, load_model
from sim_backend.shipped import shipped_file


def shipped_model_path(name: str = "thesis") -> Path:
    """Path of a shipped model file."""
    return shipped_file("models", f"{name}.yaml")


def shipped_model(name: str = "thesis") -> AntennaModel:
    """A shipped model; `thesis` is the antenna of the thesis with the corrections in docs/reading-the-thesis.md."""
    return load_model(shipped_model_path(name))
