"""Docs hold together: links lead somewhere, sources ship, decision records have their parts and stand in the index."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent.parent
PAGES = sorted([*(ROOT / "docs").rglob("*.md"), *ROOT.glob("*.md")])
RECORDS = sorted((ROOT / "docs" / "decisions").glob("[0-9]*.md"))
CODE = [
    path for room in ("firmware_protocol", "sim_backend", "gimbal_hil", "tests") for path in (ROOT / room).rglob("*.py")
]


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_link_of_a_page_leads_to_a_file(page: Path) -> None:
    links = re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text())
    lost = [link for link in links if "://" not in link and not (page.parent / link).exists()]
    assert not lost


def test_every_page_that_code_cites_is_there() -> None:
    cited = {found for path in CODE for found in re.findall(r"\bdocs/[\w/-]+\.md\b", path.read_text())}
    assert cited and not [page for page in sorted(cited) if not (ROOT / page).exists()]


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: record.stem)
def test_a_decision_record_has_number_title_date_and_status_and_stands_in_the_index(record: Path) -> None:
    text = record.read_text()
    assert re.match(rf"# {record.name[:4]} \S", text), "the first line is '# NNNN title'"
    assert re.search(r"\b20\d\d-\d\d-\d\d\b", "\n".join(text.splitlines()[:6])), "the date stands beside the status"
    assert re.search(r"status", "\n".join(text.splitlines()[:6]), re.IGNORECASE)
    assert f"({record.name})" in (ROOT / "docs" / "decisions" / "README.md").read_text(), (
        "a line in docs/decisions/README.md"
    )
