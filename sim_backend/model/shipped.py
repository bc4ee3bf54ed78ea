"""The models that come with the package."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

from firmware_protocol.errors import BadInputError, refused_below
from sim_backend.model.model import AntennaModel, load_model
from sim_backend.shipped import shipped_file

#: the shipped antenna that controllers are judged on: it has what high gain pays for
CONTROL_ANTENNA = "realistic"


def shipped_model_path(name: str = "thesis") -> Path:
    """Path of a shipped model file."""
    return shipped_file("models", f"{name}.yaml")


def shipped_model(name: str = "thesis") -> AntennaModel:
    """A shipped model; `thesis` is the antenna of the thesis with the corrections in
    docs/explanation/reading-the-thesis.md.
    """
    return load_model(shipped_model_path(name))


def model_named(name: str | Path, key: str | None = None) -> AntennaModel:
    """The model that a person means: a file, or the name of a shipped model; BadInputError lists those. `key` is where
    a configuration names it, and is in every refusal.
    """
    text = str(name)
    if text.endswith((".yaml", ".yml")) or "/" in text or Path(text).is_file():
        with nullcontext() if key is None else refused_below(key):
            return load_model(text)
    shipped = sorted(path.stem for path in shipped_file("models").glob("*.yaml"))
    if text not in shipped:
        expected = f"{', '.join(shipped)}, or the path of a model file"
        raise BadInputError(key or "--model", f"no shipped model {text!r}", expected)
    return shipped_model(text)
