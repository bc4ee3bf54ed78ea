"""Shared by all tests: hypothesis runs the same examples on every machine, without deadlines; tests in real time are
run again where the machine stood still.
"""

import os

from hypothesis import HealthCheck, settings

from tests.real_time.repeating import pytest_runtest_protocol, pytest_terminal_summary

__all__ = ["pytest_runtest_protocol", "pytest_terminal_summary"]

settings.register_profile(
    "gimbal", deadline=None, derandomize=True, max_examples=100, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "gimbal"))
