"""The commands of docs/how-to/from-a-raw-file-to-a-verdict.md lead from six kinds of raw files to the same causes."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest

from gimbal_hil.surface.cli.app import run
from tests.docs.raw_files import WRITERS, logs

PAGE = Path(__file__).resolve().parent.parent.parent / "docs" / "how-to" / "from-a-raw-file-to-a-verdict.md"
COMMANDS = [shlex.split(line) for line in re.findall(r"^gimbal-hil (.*)$", PAGE.read_text(encoding="utf-8"), re.M)]
QUESTIONS = {words[words.index("--out") + 1]: words for words in COMMANDS if words[0] == "discrepancy"}


def test_the_page_has_a_command_for_every_kind_of_file() -> None:
    asked = {words[words.index("--measured") + 1].removeprefix("a.") for words in QUESTIONS.values()}
    assert asked == set(WRITERS) and COMMANDS[0][0] == "init"


@pytest.mark.heavy
@pytest.mark.parametrize("name", QUESTIONS)
def test_a_raw_file_leads_to_a_named_cause(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    words = QUESTIONS[name]
    for option, which in (("--measured", "a"), ("--holdout", "b")):
        path = Path(words[words.index(option) + 1])
        WRITERS[path.name.removeprefix(f"{which}.")](path, logs()[which])
    assert run(COMMANDS[0][0], COMMANDS[0][1:]) == 0
    assert run(words[0], [*words[1:], "--workers", "1"]) == 0
    found = json.loads((tmp_path / name / "verdict.json").read_text())
    told = {effect["name"]: effect["parameters"] for effect in found["effects"]}
    assert found["verdict"] == "named" and set(told) == {"cogging", "coulomb"}, found["text"]
    assert told["cogging"]["amplitude"]["value"] == pytest.approx(0.01, rel=0.05)
    assert told["coulomb"]["coulomb"]["value"] == pytest.approx(0.05, rel=0.02)
