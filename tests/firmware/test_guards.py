"""Every guard scenario of the Python device holds on the C device."""

from __future__ import annotations

from functools import partial

import pytest

from sim_backend.firmware import BenchLibrary, LibraryAntenna
from tests.device.bench import bench
from tests.device.guard_scenarios import SCENARIOS


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_guard(scenario: str, library: BenchLibrary) -> None:
    """The scenario's name is the sentence."""
    SCENARIOS[scenario](partial(bench, device=partial(LibraryAntenna, library)))
