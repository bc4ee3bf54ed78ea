"""Two commands of docs/how-to/from-a-raw-file-to-a-verdict.md lead from six kinds of raw files to the same causes."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from gimbal_hil.surface.cli.app import run
from tests.docs.raw_files import WRITERS, logs, ways

WAYS = ways()


def test_the_page_has_both_commands_for_every_kind_of_file() -> None:
    assert set(WAYS) == set(WRITERS)
    assert all([words[0] for words in way] == ["init", "check", "discrepancy"] for way in WAYS.values())


@pytest.mark.heavy
@pytest.mark.parametrize("kind", WAYS)
def test_a_raw_file_leads_to_a_named_cause_by_what_check_prints(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    init, check, question = WAYS[kind]
    for name, log in logs().items():
        WRITERS[kind](Path(f"{name}.{kind}"), log)
    assert run(init[0], init[1:]) == 0 and run(check[0], check[1:]) == 0
    assert shlex.split(capsys.readouterr().out.rpartition("next: gimbal-hil ")[2]) == question
    assert run(question[0], [*question[1:], "--workers", "1"]) == 0
    found = json.loads((tmp_path / "verdict" / "verdict.json").read_text())
    told = {effect["name"]: effect["parameters"] for effect in found["effects"]}
    assert found["verdict"] == "named" and set(told) == {"cogging", "coulomb"}, found["text"]
    assert told["cogging"]["amplitude"]["value"] == pytest.approx(0.01, rel=0.05)
    level = told["coulomb"]["coulomb"]
    assert level["low"] <= 0.05 <= level["high"] < level["low"] + 0.006
