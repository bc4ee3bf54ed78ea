"""Taking any one guard out of the C device makes a scenario fail."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest

from sim_backend.firmware import BenchLibrary, LibraryAntenna, build_library
from tests.device import mutants as python_mutants
from tests.firmware.mutants import MUTANTS, CMutant, MakeDevice, passes, survivors


def library_of(mutant: CMutant, folder: Path) -> MakeDevice:
    # without optimisation: it is built often
    return partial(LibraryAntenna, BenchLibrary(build_library(folder, mutant.sources(), "-O0")))


def test_every_mutant_of_the_python_device_is_carried_over() -> None:
    carried = {mutant.of for mutant in MUTANTS}
    assert {(one.source, one.instead) for one in python_mutants.MUTANTS} - carried == set()
    assert len(MUTANTS) == len(python_mutants.MUTANTS)
    for mutant in MUTANTS:
        assert mutant.scenarios and mutant.sources()


@pytest.mark.parametrize("mutant", MUTANTS[::8], ids=lambda mutant: mutant.source[:30])
def test_some_mutants_are_found(mutant: CMutant, library: BenchLibrary, tmp_path: Path) -> None:
    assert survivors(lambda one: library_of(one, tmp_path), [mutant]) == []


@pytest.mark.heavy
def test_no_guard_can_be_taken_out_unnoticed(library: BenchLibrary, tmp_path: Path) -> None:
    needed = sorted({name for mutant in MUTANTS for name in mutant.scenarios})
    assert [name for name in needed if not passes(name, partial(LibraryAntenna, library))] == []
    assert survivors(lambda mutant: library_of(mutant, tmp_path)) == []
