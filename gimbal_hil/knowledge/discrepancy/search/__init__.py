"""The search: screen candidates, add causes that improve the fit, retry every one, drop those that do not help."""

from gimbal_hil.knowledge.discrepancy.search.candidates import numbers_of
from gimbal_hil.knowledge.discrepancy.search.comparing import (
    OUT_OF_REACH,
    clearly_better,
    no_worse,
    same_to_a_twin,
    surely,
)
from gimbal_hil.knowledge.discrepancy.search.curve import curve_does_as_well, orders_make_a_series
from gimbal_hil.knowledge.discrepancy.search.release import as_causes, given_back, numbers_instead, with_more_room
from gimbal_hil.knowledge.discrepancy.search.screening import basis_of, beside, respond, responses, row_weights
from gimbal_hil.knowledge.discrepancy.search.search import Path, control_share, extended, in_its_place, pruned
from gimbal_hil.knowledge.discrepancy.search.stories import explain, explain_again

__all__ = [
    "OUT_OF_REACH",
    "Path",
    "as_causes",
    "basis_of",
    "beside",
    "clearly_better",
    "control_share",
    "curve_does_as_well",
    "explain",
    "explain_again",
    "extended",
    "given_back",
    "in_its_place",
    "no_worse",
    "numbers_instead",
    "numbers_of",
    "orders_make_a_series",
    "pruned",
    "respond",
    "responses",
    "row_weights",
    "same_to_a_twin",
    "surely",
    "with_more_room",
]
