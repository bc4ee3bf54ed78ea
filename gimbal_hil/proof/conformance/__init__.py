"""Conformance: numbered requirements on an antenna's firmware, each checked over its frames."""

from gimbal_hil.proof.conformance.carriers import Carrier, InStep, OverLink
from gimbal_hil.proof.conformance.opening import open_antenna
from gimbal_hil.proof.conformance.reporting import in_one_line, write_report
from gimbal_hil.proof.conformance.requirements import GROUPS, Requirement, shipped_requirements
from gimbal_hil.proof.conformance.running import CHECKS, Bench, RequirementFinding, RequirementVerdict, check_all
from gimbal_hil.proof.conformance.stand import Stand

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
