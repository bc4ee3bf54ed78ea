"""Taking any one guard out of the drive's code makes a scenario fail."""

from __future__ import annotations

import json

import pytest

from tests.interpreted import run_interpreted


@pytest.mark.heavy
def test_no_guard_can_be_taken_out_unnoticed() -> None:
    """Each mutant is the drive's source without one guard, interpreted because compiling it anew would take minutes."""
    answer = json.loads(run_interpreted("tests.device.mutants"))
    assert answer["mutants"] > 40
    assert answer["broken"] == []
    assert answer["survivors"] == []
