"""Assertions in the scenarios explain themselves as those in tests do."""

import pytest

pytest.register_assert_rewrite("tests.device.guard_scenarios")
