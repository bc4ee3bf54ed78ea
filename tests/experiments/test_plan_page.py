"""The page on plan files says what the classes have."""

from __future__ import annotations

from pathlib import Path

import pytest

from gimbal_hil.knowledge.experiments import REFERENCE_SHAPES
from gimbal_hil.knowledge.experiments.plan_page import plan_page

PAGE = Path(__file__).resolve().parents[2] / "docs" / "reference" / "plan-file.md"


def test_the_kept_page_is_what_the_classes_give() -> None:
    if not PAGE.exists():
        pytest.skip("needs the source checkout")
    assert PAGE.read_text() == plan_page(), "python -m gimbal_hil.knowledge.experiments.plan_page"


@pytest.mark.parametrize(("name", "shape"), REFERENCE_SHAPES.items())
def test_every_key_of_every_shape_stands_on_the_page(name: str, shape: type) -> None:
    section = plan_page().partition(f"**`{name}`**")[2].partition("**`")[0]
    keys = set(shape.model_fields) - {"shape", "from_start"}
    assert keys and all(f"| `{key}" in section for key in keys)
