"""The page on the numbers of a model says what the table of numbers has."""

from __future__ import annotations

from pathlib import Path

import pytest

from sim_backend.model.number_page import number_page

PAGE = Path(__file__).resolve().parents[2] / "docs" / "reference" / "model-numbers.md"


def test_the_kept_page_is_what_the_table_gives() -> None:
    if not PAGE.exists():
        pytest.skip("needs the source checkout")
    assert PAGE.read_text() == number_page(), "python -m sim_backend.model.number_page"


def test_a_number_has_unit_range_and_default_in_its_row() -> None:
    row = "| `friction.shape` | 1 |  | 0.1 .. 20 | 1 | delta, exponent of the Stribeck curve |"
    assert row in number_page().splitlines()
