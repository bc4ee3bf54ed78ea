"""A part of a kernel is translated once, by another process meanwhile, and all the same where that one fails."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest

pytestmark = [
    pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled"),
    pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="no processor for another process"),
]

LAWS = """
from firmware_protocol.compiling import FLOATS, assembled_entry_point, part


@part(FLOATS)
def total(x):
    found = 0.0
    for k in range(x.size):
        found += x[k]
    return found


@assembled_entry_point(total)
def twice(x):
    return 2.0 * total(x)


@assembled_entry_point(total)
def thrice(x):
    return 3.0 * total(x)
"""


def asked(folder: Path, program: str) -> list[str]:
    """What a program says that has `laws` and nothing on disk but what was left there before."""
    (folder / "laws.py").write_text(LAWS)
    cache = folder / "cache"
    cache.mkdir(mode=0o700, exist_ok=True)
    path = os.pathsep.join([str(folder), *filter(None, [os.environ.get("PYTHONPATH")])])
    return subprocess.run(
        [sys.executable, "-c", f"import sys, numpy as np, laws\n{program}"],
        env=os.environ | {"GIMBAL_HIL_CACHE": str(cache), "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    ).stdout.split()


#: the answer, and how often the part was found on disk and translated here
_TOLD = "print(laws.{}(np.arange(4.0)), sum(laws.total._cache_hits.values()), sum(laws.total._cache_misses.values()))"


def test_another_process_translates_a_part_and_other_kernels_find_it(tmp_path: Path) -> None:
    assert asked(tmp_path, _TOLD.format("twice")) == ["12.0", "1", "0"]
    assert asked(tmp_path, _TOLD.format("thrice")) == ["18.0", "1", "0"]
    # the kernel itself is on disk now, and asks for no part
    assert asked(tmp_path, _TOLD.format("thrice")) == ["18.0", "0", "0"]


def test_a_part_that_the_other_process_does_not_leave_is_translated_here(tmp_path: Path) -> None:
    assert asked(tmp_path, f"sys.executable = '/bin/false'; {_TOLD.format('twice')}") == ["12.0", "0", "1"]
