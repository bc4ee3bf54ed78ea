"""Recognises the kind of a file by its content."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path

from firmware_protocol.documents import read_yaml
from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.data.containers import container_of
from gimbal_hil.data.runs import RUN_FILE
from gimbal_hil.data.tables import is_text_table

#: what people write by hand, though it may begin as JSON does
_WRITTEN = (".yaml", ".yml")
_TABLES = (".csv", ".tsv", ".parquet", ".pq", ".npz", ".npy")
_EXPECTED = "a model, configuration or plan (YAML), a table of signals (CSV, Parquet, npz) or a run folder"
#: keys that only one kind of document has; the first kind that has one of the file's keys is meant
_TELLING: dict[FileKind, frozenset[str]]


class FileKind(StrEnum):
    """Kinds of files that are read."""

    CONFIGURATION = "configuration"
    MODEL = "model"
    PLAN = "plan"
    SIGNALS = "signals table"
    RUN = "run folder"


_TELLING = {
    FileKind.PLAN: frozenset({"segments", "laps"}),
    FileKind.CONFIGURATION: frozenset({"link", "rate_hz", "supervisor", "recording", "operator", "antenna"}),
    FileKind.MODEL: frozenset({"kind", "effects", "gravity_m_s2", "plant_step_s", "uncertainty", "base"}),
}


def kind_of(path: Path) -> tuple[FileKind, Json]:
    """Kind of a file and, for YAML, its document; BadInputError where it cannot be read or is none of them."""
    if path.suffix.lower() not in _WRITTEN and container_of(path) is not None:
        return FileKind.SIGNALS, {}
    if path.is_dir():
        if not (path / RUN_FILE).exists():
            raise BadInputError(str(path), f"is a folder without {RUN_FILE}", _EXPECTED)
        return FileKind.RUN, {}
    if path.suffix.lower() in _TABLES or (path.suffix.lower() not in _WRITTEN and is_text_table(path)):
        return FileKind.SIGNALS, {}
    document = read_yaml(path, _EXPECTED)
    found = next((kind for kind, keys in _TELLING.items() if keys & document.keys()), None)
    if found is None and _has_loops(document):
        found = FileKind.CONFIGURATION
    if found is None:
        raise BadInputError(str(path), f"has the keys {', '.join(document) or 'none'}", _EXPECTED)
    return found, document


def _has_loops(document: dict[str, object]) -> bool:
    """Whether its axes have what only a configuration gives them; such a file may leave out everything else."""
    axes = document.get("axes")
    sections = axes.values() if isinstance(axes, dict) else ()
    return any(isinstance(section, dict) and {"rate_loop", "position_loop"} & section.keys() for section in sections)
