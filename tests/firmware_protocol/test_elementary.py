"""Elementary functions against arithmetic of 120 bits, and compiled against interpreted."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from firmware_protocol.compiling import entry_point
from firmware_protocol.elementary import exponential, logarithm_of_two, power_of_two, sine_cosine

mpmath = pytest.importorskip("mpmath", reason="mpmath is not installed (the extra test has it)")
COUNT = 2000


@entry_point
def many(which: int, x: np.ndarray, y: np.ndarray) -> None:
    """y = function `which` of x, elements one by one."""
    for i in range(x.shape[0]):
        if which == 0:
            y[i] = exponential(x[i])
        elif which == 1:
            y[i] = power_of_two(x[i])
        elif which == 2:
            y[i] = logarithm_of_two(x[i])
        elif which == 3:
            y[i] = sine_cosine(x[i])[0]
        else:
            y[i] = sine_cosine(x[i])[1]


EXACT: tuple[Callable[[Any], Any], ...] = (
    mpmath.exp,
    lambda x: mpmath.mpf(2) ** x,
    lambda x: mpmath.log(x) / mpmath.log(2),
    mpmath.sin,
    mpmath.cos,
)


def arguments(which: int) -> np.ndarray:
    """Where the function is used, near the edges of its tables too."""
    rng = np.random.default_rng(which)
    if which == 2:
        return np.concatenate(
            [np.exp(rng.uniform(-20, 3, COUNT)), 1.0 + rng.uniform(-0.01, 0.01, COUNT), 1.0 + np.arange(256) / 256]
        )
    width = (700.0, 900.0, 0.0, 1e3, 1e3)[which]
    return np.concatenate(
        [rng.uniform(-width, width, COUNT), rng.uniform(-0.05, 0.05, COUNT), np.arange(-512, 513) * math.pi / 256]
    )


@pytest.mark.parametrize("which", range(5), ids=["exponential", "power of two", "logarithm", "sine", "cosine"])
def test_two_units_in_the_last_place_or_three_parts_in_ten_to_the_sixteen(which: int) -> None:
    x = arguments(which)
    y = np.zeros_like(x)
    many(which, x, y)
    with mpmath.workprec(120):
        exact = [EXACT[which](mpmath.mpf(v)) for v in x.tolist()]
        error = np.array([abs(float(mpmath.mpf(got) - true)) for got, true in zip(y.tolist(), exact, strict=True)])
    allowed = np.maximum(2.0 * np.spacing(np.abs([float(v) for v in exact])), 3e-16)
    assert np.all(error <= allowed), (x[np.argmax(error / allowed)], np.max(error / allowed))


def test_interpreted_they_give_the_same_bits(tmp_path: Path) -> None:
    code = """
import sys, numpy as np
from firmware_protocol.elementary import exponential, logarithm_of_two, power_of_two, sine_cosine
which, x = int(sys.argv[1]), np.load(sys.argv[2])
function = (
    exponential, power_of_two, logarithm_of_two, lambda v: sine_cosine(v)[0], lambda v: sine_cosine(v)[1],
)[which]
np.save(sys.argv[3], [function(v) for v in x.tolist()])
"""
    root = Path(__file__).resolve().parents[2]
    environment = dict(os.environ, NUMBA_DISABLE_JIT="1", PYTHONPATH=str(root))
    for which in range(5):
        x = arguments(which)[::5].copy()
        y = np.zeros_like(x)
        many(which, x, y)
        given, answered = tmp_path / f"given{which}.npy", tmp_path / f"answered{which}.npy"
        np.save(given, x)
        subprocess.run(
            [sys.executable, "-W", "ignore", "-c", code, str(which), str(given), str(answered)],
            env=environment,
            check=True,
        )
        assert np.load(answered).tobytes() == y.tobytes()


def test_beyond_their_tables_they_are_the_library_s() -> None:
    with np.errstate(all="ignore"):
        x = np.array([1e7, -3e9, 710.0, -800.0])
        y = np.zeros_like(x)
        many(3, x, y)
        assert y[0] == math.sin(1e7) and y[1] == math.sin(-3e9)
        many(0, x, y)
        assert y[2] == math.inf and y[3] == 0.0
    assert all(math.isnan(v) for v in sine_cosine(math.nan))
