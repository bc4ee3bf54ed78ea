"""A survey of a shipped antenna leaves nothing but noise of its own model: an improvement of it would end at once."""

from __future__ import annotations

import pytest

from sim_backend.model import shipped_model
from tests.improvement.antennas import judged
from tests.improvement.run import REACHED_FLOORS


@pytest.mark.parametrize("name", ["thesis", "realistic"])
def test_an_antenna_is_at_the_floor_of_its_own_model(name: str) -> None:
    assert judged(shipped_model(name), shipped_model(name)) < REACHED_FLOORS
