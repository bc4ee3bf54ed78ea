"""A place that cannot hold the result is refused before the work, in one line."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from firmware_protocol.errors import BadInputError
from firmware_protocol.places import require_new
from gimbal_hil.surface.cli.app import run
from sim_backend.shipped import shipped_file


def test_a_new_folder_however_deep_is_good(tmp_path: Path) -> None:
    require_new(tmp_path / "a" / "b", False, "report.html")
    assert list(tmp_path.iterdir()) == []


def test_a_file_of_that_name_is_kept_unless_forced(tmp_path: Path) -> None:
    (tmp_path / "report.html").touch()
    with pytest.raises(BadInputError, match=r"report.html: already exists; expected a new folder, or --force"):
        require_new(tmp_path, False, "model.yaml", "report.html")
    require_new(tmp_path, True, "report.html")
    require_new(tmp_path, False, "model.yaml")


def test_a_link_is_what_lies_there_wherever_it_leads(tmp_path: Path) -> None:
    dangling, loop, report = tmp_path / "dangling", tmp_path / "loop", tmp_path / "report.html"
    dangling.symlink_to(tmp_path / "nothing")
    loop.symlink_to(loop)
    report.symlink_to(tmp_path / "nothing.html")
    for folder, link in ((dangling, dangling), (dangling / "x", dangling), (loop, loop), (loop / "x" / "y", loop)):
        with pytest.raises(BadInputError) as refused:
            require_new(folder, False, "report.html")
        said = f"{link} is a link that leads to no folder; expected a folder that can be written to"
        assert str(refused.value) == f"{folder}: {said}"
    with pytest.raises(BadInputError, match=r"report\.html: already exists"):
        require_new(tmp_path, False, "report.html")
    (tmp_path / "nothing").mkdir()
    require_new(dangling / "x", False, "report.html")


def test_whether_one_may_write_is_asked_before_what_is_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "report.html").touch()
    monkeypatch.setattr(os, "access", lambda *_: False)
    for force in (False, True):
        with pytest.raises(BadInputError, match=f"nothing may be written in {tmp_path}; expected a folder that can be"):
            require_new(tmp_path, force, "report.html")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_may_not_be_looked_into_is_refused_before_the_names_in_it(tmp_path: Path) -> None:
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o600)
    (tmp_path / "into").symlink_to(closed / "below")
    with pytest.raises(BadInputError, match=f"nothing may be written in {closed}; expected a folder that can be"):
        require_new(closed, False, "report.html")
    with pytest.raises(BadInputError, match="is a link that leads to no folder; expected"):
        require_new(tmp_path / "into", False, "report.html")


@pytest.mark.parametrize(
    "words",
    [
        ["discrepancy", "--measured", "none.csv", "--out"],
        ["identify", "none.csv", "--out"],
        ["improve", "--out"],
        ["campaign", "step", "--out"],
        ["point", "--target", "azel:120,35", "--out"],
        ["point", "--target", "azel:120,35", "--run", "none", "--out"],
        ["tune", "--config", str(shipped_file("virtual_antenna.yaml")), "--out"],
        ["init", "--yes"],
        ["replay", "none", "--learned"],
        ["service", "container", "--out"],
    ],
)
def test_a_folder_below_a_file_is_refused_before_a_log_is_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str]
) -> None:
    (tmp_path / "notes").write_text("mine")
    with pytest.raises(SystemExit) as end:
        run(words[0], [*words[1:], str(tmp_path / "notes" / "found" / "x")])
    assert end.value.code == 2
    said = capsys.readouterr().err
    assert f"{tmp_path / 'notes'} is a file; expected a folder that can be written to" in said
    assert len(said.splitlines()) == 1
