"""Files that people write: their kind, checks by the loaders that all commands use, and their JSON schemas."""

from gimbal_hil.surface.checking.checks import UNNAMED_AXIS, Checked, check_files
from gimbal_hil.surface.checking.kinds import FileKind, kind_of
from gimbal_hil.surface.checking.schemas import SCHEMA_KINDS, SCHEMA_LINE, schema_of, schema_text

__all__ = [
    "SCHEMA_KINDS",
    "SCHEMA_LINE",
    "UNNAMED_AXIS",
    "Checked",
    "FileKind",
    "check_files",
    "kind_of",
    "schema_of",
    "schema_text",
]
