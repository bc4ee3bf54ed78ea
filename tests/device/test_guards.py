"""Every guard of the drive does what it is there for."""

from __future__ import annotations

import pytest

from tests.device.bench import bench
from tests.device.guard_scenarios import SCENARIOS


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_guard(scenario: str) -> None:
    """The scenario's name is the sentence."""
    SCENARIOS[scenario](bench)
