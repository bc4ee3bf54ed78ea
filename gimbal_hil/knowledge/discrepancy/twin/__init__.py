"""The twin: a model with effects switched on, evaluated along measured motion."""

from gimbal_hil.knowledge.discrepancy.twin.number_slots import number_slot, read_number, turned_inertia, write_number
from gimbal_hil.knowledge.discrepancy.twin.physical import Bounds, keep_physical, keep_within
from gimbal_hil.knowledge.discrepancy.twin.record import (
    RATE_ERROR,
    TORQUE,
    Channel,
    Record,
    edge_rows,
    judging_name,
    record_of,
    reread,
    searched_name,
)
from gimbal_hil.knowledge.discrepancy.twin.smoothing import Bands, Floats, scored, scoring_gain, scoring_reach
from gimbal_hil.knowledge.discrepancy.twin.twin import Evaluation, Structure, Twin

__all__ = [
    "RATE_ERROR",
    "TORQUE",
    "Bands",
    "Bounds",
    "Channel",
    "Evaluation",
    "Floats",
    "Record",
    "Structure",
    "Twin",
    "edge_rows",
    "judging_name",
    "keep_physical",
    "keep_within",
    "number_slot",
    "read_number",
    "record_of",
    "reread",
    "scored",
    "scoring_gain",
    "scoring_reach",
    "searched_name",
    "turned_inertia",
    "write_number",
]
