"""The judgement: which of the causes found are told, and how surely."""

from gimbal_hil.knowledge.discrepancy.judgement.deciding import Kind, Status, Told, decide
from gimbal_hil.knowledge.discrepancy.judgement.intervals import number_intervals, parameter_intervals
from gimbal_hil.knowledge.discrepancy.judgement.measured_torque import torque_is_measured, with_measured_torque
from gimbal_hil.knowledge.discrepancy.judgement.result import Request, Result
from gimbal_hil.knowledge.discrepancy.judgement.rivals import Rival

__all__ = [
    "Kind",
    "Request",
    "Result",
    "Rival",
    "Status",
    "Told",
    "decide",
    "number_intervals",
    "parameter_intervals",
    "torque_is_measured",
    "with_measured_torque",
]
