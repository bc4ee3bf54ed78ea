"""Conformance: numbered requirements on an antenna's firmware, each checked over its frames."""

from gimbal_hil.conformance.carriers import Carrier, InStep, OverLink
from gimbal_hil.conformance.opening import open_antenna
from gimbal_hil.conformance.reporting import in_one_line, write_report
from gimbal_hil.conformance.requirements import GROUPS, Requirement, shipped_requirements
from gimbal_hil.conformance.running import CHECKS, Bench, RequirementFinding, RequirementVerdict, check_all
from gimbal_hil.conformance.stand import Stand

__all__ = [
    "CHECKS",
    "GROUPS",
    "Bench",
    "Carrier",
    "InStep",
    "OverLink",
    "Requirement",
    "RequirementFinding",
    "RequirementVerdict",
    "Stand",
    "check_all",
    "in_one_line",
    "open_antenna",
    "shipped_requirements",
    "write_report",
]
