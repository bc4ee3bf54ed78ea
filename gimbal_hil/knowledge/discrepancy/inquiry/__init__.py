"""What is searched, as one frozen value: logs, floors, candidates, known numbers; and how a hypothesis stands there."""

from gimbal_hil.knowledge.discrepancy.inquiry.inquiry import (
    PARTS,
    Inquiry,
    State,
    gain_on,
    mean_squares,
    refitted,
    rms,
    settled,
    shared,
    squares_of,
    stands_out,
    state_of,
    surely_less,
    weighing_of,
)
from gimbal_hil.knowledge.discrepancy.inquiry.policy import BLOCK_S, DRAWS, LEAST_GAP, MOST_CAUSES, MOST_ENTRIES, Policy
from gimbal_hil.knowledge.discrepancy.inquiry.preflight import LEAST_S, band_within, check_logs
from gimbal_hil.knowledge.discrepancy.inquiry.prepare import (
    Noise,
    as_stated,
    effect_names,
    prepared,
    recalibrated,
    scored_band,
)
from gimbal_hil.knowledge.discrepancy.inquiry.standing import standing
from gimbal_hil.knowledge.discrepancy.inquiry.yardstick import without_candidate

__all__ = [
    "BLOCK_S",
    "DRAWS",
    "LEAST_GAP",
    "LEAST_S",
    "MOST_CAUSES",
    "MOST_ENTRIES",
    "PARTS",
    "Inquiry",
    "Noise",
    "Policy",
    "State",
    "as_stated",
    "band_within",
    "check_logs",
    "effect_names",
    "gain_on",
    "mean_squares",
    "prepared",
    "recalibrated",
    "refitted",
    "rms",
    "scored_band",
    "settled",
    "shared",
    "squares_of",
    "standing",
    "stands_out",
    "state_of",
    "surely_less",
    "weighing_of",
    "without_candidate",
]
