"""Everything that is written out from the schema: constants, dataclasses, DBC, C header, documentation."""

from firmware_protocol.emit.field_words import emit_field_words
from firmware_protocol.emit.mail import emit_mail
from firmware_protocol.emit.messages import emit_messages

__all__ = ["emit_field_words", "emit_mail", "emit_messages"]
