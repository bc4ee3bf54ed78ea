"""The forms that the schema is emitted in, and where each is kept in the source tree."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from firmware_protocol.errors import BadInputError

#: form -> (module of this folder, its function, file relative to the source tree); imported one by one,
#: because after a change of the schema the docs cannot be made before the emitted modules are
FORMS: dict[str, tuple[str, str, str]] = {
    "mail": ("mail", "emit_mail", "firmware_protocol/mail.py"),
    "messages": ("messages", "emit_messages", "firmware_protocol/messages.py"),
    "field_words": ("field_words", "emit_field_words", "firmware_protocol/field_words.py"),
    "dbc": ("dbc", "emit_dbc", "firmware_protocol/gimbal.dbc"),
    "c": ("c_header", "emit_c", "firmware_protocol/gimbal_protocol.h"),
    "docs": ("wire_docs", "emit_docs", "docs/reference/wire.md"),
}


def emit(form: str) -> str:
    """Text of one form; BadInputError for a form that does not exist."""
    if form not in FORMS:
        raise BadInputError("--emit", f"no form {form!r}", ", ".join(FORMS))
    module, function, _ = FORMS[form]
    return str(getattr(import_module(f"firmware_protocol.emit.{module}"), function)())


def committed_path(form: str) -> Path:
    """Where the emitted form is kept."""
    return Path(__file__).parents[2] / FORMS[form][2]
