"""Parts of a matrix of tests that are run in any run, beside those that are `heavy`."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def heavy_but(soon: Collection[Any], values: Iterable[Any]) -> list[Any]:
    """Parameters of a matrix: those of `soon` as they are, all others marked `heavy`."""
    return [value if value in soon else pytest.param(value, marks=pytest.mark.heavy) for value in values]
