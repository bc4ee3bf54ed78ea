"""Taking any one guard out of the C device makes a scenario fail."""

from __future__ import annotations

from pathlib import Path

import pytest

from sim_backend.firmware import BenchLibrary
from tests.device import mutants as python_mutants
from tests.firmware.mutants import MUTANTS, CMutant, library_of, passes


def survives(mutant: CMutant, folder: Path) -> bool:
    library = library_of(mutant, folder)
    return all(passes(scenario, library) for scenario in mutant.scenarios)


def test_every_mutant_of_the_python_device_is_carried_over() -> None:
    carried = {mutant.of for mutant in MUTANTS}
    assert {(one.source, one.instead) for one in python_mutants.MUTANTS} - carried == set()
    assert len(MUTANTS) == len(python_mutants.MUTANTS)
    for mutant in MUTANTS:
        assert mutant.scenarios and mutant.sources()


@pytest.mark.parametrize("mutant", MUTANTS[::8], ids=lambda mutant: mutant.source[:30])
def test_some_mutants_are_found(mutant: CMutant, library: BenchLibrary, tmp_path: Path) -> None:
    assert not survives(mutant, tmp_path)


@pytest.mark.heavy
def test_no_guard_can_be_taken_out_unnoticed(library: BenchLibrary, tmp_path: Path) -> None:
    needed = sorted({name for mutant in MUTANTS for name in mutant.scenarios})
    assert [name for name in needed if not passes(name, library)] == []
    assert [f"{one.file}: {one.source!r}" for one in MUTANTS if survives(one, tmp_path)] == []
