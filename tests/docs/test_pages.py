"""Docs hold together: links lead somewhere, sources ship, decision records have their parts and stand in the index."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from gimbal_hil.data.runs import FRAME_ROW, TICK_ROW
from gimbal_hil.data.signals import read_signals

ROOT = Path(__file__).resolve().parent.parent.parent
PAGES = sorted([*(ROOT / "docs").rglob("*.md"), *ROOT.glob("*.md")])
RECORDS = sorted((ROOT / "docs" / "decisions").glob("[0-9]*.md"))
INDEX = (ROOT / "docs" / "decisions" / "README.md").read_text()
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


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_prose_is_wrapped_at_120(page: Path) -> None:
    # tables, code and what has no blank to break at are as long as they are
    text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    prose = [line for line in text.splitlines() if not line.startswith(("|", "    "))]
    assert not [line for line in prose if len(line) > 120 and " " in re.sub(r"^ *([-*]|\d+\.) ", "", line)]


def test_every_page_that_code_cites_is_there() -> None:
    cited = {found for path in CODE for found in re.findall(r"\bdocs/[\w/-]+\.md\b", path.read_text())}
    assert cited and not [page for page in sorted(cited) if not (ROOT / page).exists()]


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: record.stem)
def test_a_decision_record_has_number_title_date_and_status_and_stands_in_the_index(record: Path) -> None:
    text = record.read_text()
    assert re.match(rf"# {record.name[:4]} \S", text), "the first line is '# NNNN title'"
    number, title = text.splitlines()[0].removeprefix("# ").split(" ", 1)
    said = re.search(r"Status: (.+?)\. Date: (20\d\d-\d\d-\d\d)\.", " ".join(text.splitlines()[1:6]))
    assert said, "the third line is 'Status: .... Date: YYYY-MM-DD.'"
    assert not said[1].startswith("replaced"), "its file goes; docs/decisions/README.md keeps a line below Replaced"
    row = f"- [{number}]({record.name})\n  {title}\n"
    assert row in INDEX.partition("\n## Replaced\n")[0], f"docs/decisions/README.md has {row!r}"


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: record.stem)
def test_a_decision_record_says_why_what_and_what_follows(record: Path) -> None:
    text = record.read_text()
    context, decision, follows = (text.find(f"\n**{part}") for part in ("Context.", "Decision", "Consequences."))
    assert 0 < context < decision < follows


def test_every_decision_has_a_number_of_its_own_and_the_index_is_in_their_order() -> None:
    held, _, replaced = INDEX.partition("\n## Replaced\n")
    numbers = re.findall(r"^- \[(\d{4})\]", held, re.MULTILINE)
    assert numbers == sorted(set(numbers)) == [record.name[:4] for record in RECORDS]
    gone = re.findall(r"^- (\d{4}) \S.*\n  \[(\d{4})\]\(\2-\S+\.md\)$", replaced, re.MULTILINE)
    olds, successors = {old for old, _ in gone}, {new for _, new in gone}
    assert [old for old, _ in gone] == sorted(olds) and len(gone) == len(re.findall("^- ", replaced, re.MULTILINE))
    assert not olds & set(numbers) and successors <= set(numbers)


@pytest.mark.parametrize(("file", "row"), [("ticks.arrow", TICK_ROW), ("frames.arrow", FRAME_ROW)])
def test_the_page_on_the_run_folder_has_every_column_with_its_type(file: str, row: np.dtype) -> None:
    page = (ROOT / "docs" / "reference" / "run-folder.md").read_text()
    table = page.split(f"| column of `{file}` |")[1].split("\n\n")[0]
    listed = {
        name: line.split("|")[2].split(",")[0].strip()
        for line in table.splitlines()[2:]
        for name in re.findall(r"`(\w+)`", line.split("|")[1])
    }
    assert listed == {name: row[name].name for name in row.names}


def test_the_table_on_the_page_of_signals_is_read_as_it_stands(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "reference" / "signals-table.md").read_text()
    (lines,) = re.findall(r"^```csv\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    file = tmp_path / "log.csv"
    file.write_text(lines)
    table = read_signals(file, ("azimuth", "elevation"))
    assert len(table.time_s) == len(lines.splitlines()) - 1 >= 10
    assert list(table.columns["azimuth.torque"][:2]) == [0.0, 0.084]
