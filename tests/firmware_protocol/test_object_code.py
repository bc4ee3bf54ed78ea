"""Object code needs no library of Numba's, whatever this process compiled before."""

from __future__ import annotations

import subprocess
import sys

import pytest

PROGRAM = """
import numba
from firmware_protocol.compiling import compiled
from firmware_protocol.object_code import object_code

TYPES = (numba.float64[::1],)

def bits(values):
    return values.view(numba.int64)[0]

def bits_by_a_law(values):
    return law(values)

# with reference counting, as all that Python calls
numba.njit(error_model="numpy")(bits).compile(TYPES)
law = compiled(lambda values: values.view(numba.int64)[0])
print(b"NRT_" in object_code({function}, TYPES, "law"))
"""


@pytest.mark.parametrize("function", ["bits", "bits_by_a_law"])
def test_object_code_counts_no_references_though_the_same_was_compiled_with_them_before(function: str) -> None:
    words = [sys.executable, "-c", PROGRAM.format(function=function)]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False"]
