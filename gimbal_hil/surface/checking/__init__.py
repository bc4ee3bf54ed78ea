"""Files that people write: their kind, checks by the loaders that all commands use, and their JSON schemas."""

from gimbal_hil.surface.checking.checks import UNNAMED_AXIS, Checked, check_files
from gimbal_hil.surface.checking.kinds import FileKind, kind_of
from gimbal_hil.surface.checking.schemas import (
    ANSWER_SCHEMAS,
    SCHEMA_KINDS,
    SCHEMA_LINE,
    answer_schema_text,
    schema_of,
    schema_text,
)

__all__ = [
    "ANSWER_SCHEMAS",
    "SCHEMA_KINDS",
    "SCHEMA_LINE",
    "UNNAMED_AXIS",
    "Checked",
    "FileKind",
    "answer_schema_text",
    "check_files",
    "kind_of",
    "schema_of",
    "schema_text",
]
