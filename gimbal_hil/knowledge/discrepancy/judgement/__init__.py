"""The judgement: which of the causes found are reported, and how surely."""

from gimbal_hil.knowledge.discrepancy.judgement.agreement import intervals_of_both, with_identification
from gimbal_hil.knowledge.discrepancy.judgement.deciding import (
    Denial,
    Kind,
    Status,
    Told,
    beyond_noise,
    decide,
    odds_against,
)
from gimbal_hil.knowledge.discrepancy.judgement.earned import NumberError, hidden_errors, number_errors
from gimbal_hil.knowledge.discrepancy.judgement.intervals import number_intervals, parameter_intervals
from gimbal_hil.knowledge.discrepancy.judgement.measured_torque import torque_is_measured, with_measured_torque
from gimbal_hil.knowledge.discrepancy.judgement.result import Request, Result
from gimbal_hil.knowledge.discrepancy.judgement.rivals import Rival
from gimbal_hil.knowledge.discrepancy.judgement.smallest import (
    ORDER,
    Shows,
    Trace,
    channel_name,
    smallest_sizes,
    traces,
)

__all__ = [
    "ORDER",
    "Denial",
    "Kind",
    "NumberError",
    "Request",
    "Result",
    "Rival",
    "Shows",
    "Status",
    "Told",
    "Trace",
    "beyond_noise",
    "channel_name",
    "decide",
    "hidden_errors",
    "intervals_of_both",
    "number_errors",
    "number_intervals",
    "odds_against",
    "parameter_intervals",
    "smallest_sizes",
    "torque_is_measured",
    "traces",
    "with_identification",
    "with_measured_torque",
]
