"""`gimbal-hil bench faults`: what can go wrong, in every motion, on every transport, and whether the antenna was safe
in time.
"""

from gimbal_hil.proof.bench.faults.matrix import FaultOutcome, run_matrix, run_row
from gimbal_hil.proof.bench.faults.matrix_page import matrix_blocks, matrix_text
from gimbal_hil.proof.bench.faults.rig import Rig, Transport
from gimbal_hil.proof.bench.faults.rows import FaultRow, Motion, Trouble, fault_rows

__all__ = [
    "FaultOutcome",
    "FaultRow",
    "Motion",
    "Rig",
    "Transport",
    "Trouble",
    "fault_rows",
    "matrix_blocks",
    "matrix_text",
    "run_matrix",
    "run_row",
]
