"""What changed between two sets of logs: two units, days, settings or temperatures."""

from gimbal_hil.knowledge.change.change_page import change_page
from gimbal_hil.knowledge.change.comparing import Asked, ChangeKind, Comparison, Heard, compare
from gimbal_hil.knowledge.change.telling import document_of

__all__ = ["Asked", "ChangeKind", "Comparison", "Heard", "change_page", "compare", "document_of"]
