"""The journal of an improvement: typed lines, on disk at once, readable after any cut."""

from __future__ import annotations

from pathlib import Path

import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.improvement.journal import (
    Chosen,
    Ended,
    Entry,
    Journal,
    Measured,
    Refused,
    Started,
    read_journal,
)

ENTRIES: tuple[Entry, ...] = (
    Started({"short": True}),
    Chosen(
        1,
        "round_1/survey",
        "survey",
        ["outer"],
        "to search on",
        [{"sequence": "creep", "axis": "outer", "expected": 3.0}],
    ),
    Refused(1, "sweep", "needs 9 N m on outer"),
    Measured(1, "round_1/survey", "survey", "search", 35.5, 2.0),
    Ended("at_the_floor", "done", 35.5, 1),
)


def test_what_is_written_is_read_back_as_the_same_entries(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "journal.jsonl")
    for number, entry in enumerate(ENTRIES, start=1):
        journal.write(entry)
        # on disk before the next step, not when the journal is closed
        assert read_journal(journal.path) == list(ENTRIES[:number])
    journal.close()


@pytest.mark.parametrize("cut", [1, 7, 40])
def test_a_journal_that_was_cut_in_its_last_line_goes_on_after_the_line_before(tmp_path: Path, cut: int) -> None:
    path = tmp_path / "journal.jsonl"
    journal = Journal(path)
    for entry in ENTRIES:
        journal.write(entry)
    journal.close()
    path.write_bytes(path.read_bytes()[:-cut])
    again = Journal(path, resume=True)
    assert again.entries == list(ENTRIES[:-1])
    again.write(ENTRIES[-1])
    again.close()
    assert read_journal(path) == list(ENTRIES)


@pytest.mark.parametrize(
    "line",
    [
        b'{"kind": "danced"}',
        b'{"kind": ["started"], "session": {}}',
        b'{"kind": "started", "session": {}, "session": {}}',
        b'{"kind": "started", "session": {"seed": ' + 5000 * b"9" + b"}}",
        b'{"kind": "started", "session": ' + 5000 * b"[",
        b"\xff\xfe",
        b"[]",
    ],
)
def test_a_line_that_is_no_entry_is_refused_with_its_number(tmp_path: Path, line: bytes) -> None:
    path = tmp_path / "journal.jsonl"
    path.write_bytes(b'{"kind": "started", "session": {}}\n' + line + b"\n")
    with pytest.raises(BadInputError, match="line 2"):
        read_journal(path)
