"""The page on the configuration file says what the classes have, and its examples are taken by the loader."""

from __future__ import annotations

from pathlib import Path
from typing import Any, get_args

import pytest
from pydantic import BaseModel, Field

from firmware_protocol.documents import key_table, read_yaml, yaml_mapping
from gimbal_hil.loop.settings import DaemonSettings, settings_from_document, shipped_settings_path
from gimbal_hil.loop.settings.configuration_page import LINK_EXAMPLES, configuration_page
from gimbal_hil.loop.settings.link import LINK_KINDS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "reference" / "configuration.md"


def test_the_kept_page_is_what_the_classes_give() -> None:
    if not PAGE.exists():
        pytest.skip("needs the source checkout")
    assert PAGE.read_text() == configuration_page(), "python -m gimbal_hil.loop.settings.configuration_page"


def test_there_is_an_example_of_every_kind_of_link() -> None:
    assert [kind for kind, _, _ in LINK_EXAMPLES] == list(LINK_KINDS)


@pytest.mark.parametrize(("kind", "example"), [(kind, example) for kind, _, example in LINK_EXAMPLES])
def test_a_link_example_is_taken_by_the_loader(kind: str, example: str) -> None:
    document: dict[str, Any] = dict(read_yaml(shipped_settings_path(), ""))
    document["link"] = yaml_mapping(example, kind, "a link")["link"]
    if kind == "adapter":
        # drives of another make have no gyro
        for axis in document["axes"].values():
            for guard in ("gyro_encoder_rad_s", "gyro_encoder_rad", "stuck_gyro_ticks"):
                del axis["limits"][guard]
    assert type(settings_from_document(document, "example").link) is LINK_KINDS[kind]


def test_a_key_without_a_description_has_no_row_to_stand_in() -> None:
    class Mute(BaseModel):
        key: float

    with pytest.raises(AssertionError, match=r"Mute\.key has no description"):
        key_table(Mute)


def test_a_row_has_bounds_unit_default_and_meaning() -> None:
    class Section(BaseModel):
        rate_rad_s: float = Field(gt=0.0, le=5.0, description="how fast")
        count: int = Field(default=3, description="how many")

    assert key_table(Section)[2:] == [
        "| `rate_rad_s` | above 0 to 5, rad/s | **needed** | how fast |",
        "| `count` | whole | 3 | how many |",
    ]


def sections_of(section: type[BaseModel]) -> set[type[BaseModel]]:
    """Every class that a file can have a section of, below this one."""
    found: set[type[BaseModel]] = set()

    def look(kind: object) -> None:
        for part in get_args(kind):
            look(part)
        if isinstance(kind, type) and issubclass(kind, BaseModel) and kind not in found:
            found.add(kind)
            for field in kind.model_fields.values():
                look(field.annotation)

    look(section)
    return found


def test_every_section_that_a_file_can_have_stands_on_the_page() -> None:
    page = configuration_page()
    assert {"ModelControl", "JointObserver"} <= {one.__name__ for one in sections_of(DaemonSettings)}
    for one in sections_of(DaemonSettings):
        # a section's own keys, or a heading of its own as `link.embedded` has
        keys = [field.alias or name for name, field in one.model_fields.items()]
        assert all(f"| `{key}` |" in page or f"## `link.{key}`" in page for key in keys), one
