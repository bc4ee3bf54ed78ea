"""Shared by all tests: hypothesis runs the same examples on every machine, without deadlines."""

import os

from hypothesis import HealthCheck, settings

settings.register_profile(
    "gimbal", deadline=None, derandomize=True, max_examples=100, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "gimbal"))
