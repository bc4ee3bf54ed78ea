"""Everything that is written out from the schema: constants, dataclasses, DBC, C header, documentation."""

from firmware_protocol.emit.forms import FORMS, committed_path, emit

__all__ = ["FORMS", "committed_path", "emit"]
