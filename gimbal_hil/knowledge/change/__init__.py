"""What changed between two sets of logs: two units, days, settings or temperatures."""

from gimbal_hil.knowledge.change.change_page import change_page
from gimbal_hil.knowledge.change.comparing import AskedCause, ChangeKind, Heard, MachineComparison, compare
from gimbal_hil.knowledge.change.schema import CHANGED_SCHEMA
from gimbal_hil.knowledge.change.telling import document_of

__all__ = [
    "CHANGED_SCHEMA",
    "AskedCause",
    "ChangeKind",
    "Heard",
    "MachineComparison",
    "change_page",
    "compare",
    "document_of",
]
