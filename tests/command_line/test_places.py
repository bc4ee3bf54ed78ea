"""A place that cannot hold the result is refused before the work, in one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.cli.app import run
from gimbal_hil.cli.places import require_new


def test_a_new_folder_however_deep_is_good(tmp_path: Path) -> None:
    require_new(tmp_path / "a" / "b", False, "report.html")
    assert list(tmp_path.iterdir()) == []


def test_a_file_of_that_name_is_kept_unless_forced(tmp_path: Path) -> None:
    (tmp_path / "report.html").touch()
    with pytest.raises(BadInputError, match=r"report.html: already exists; expected a new folder, or --force"):
        require_new(tmp_path, False, "model.yaml", "report.html")
    require_new(tmp_path, True, "report.html")
    require_new(tmp_path, False, "model.yaml")


@pytest.mark.parametrize("command", ["discrepancy", "identify"])
def test_a_folder_below_a_file_is_refused_before_a_log_is_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    (tmp_path / "notes").write_text("mine")
    logs = ["--measured", "none.csv"] if command == "discrepancy" else ["none.csv"]
    with pytest.raises(SystemExit) as end:
        run(command, [*logs, "--out", str(tmp_path / "notes" / "found")])
    assert end.value.code == 2
    said = capsys.readouterr().err
    assert f"{tmp_path / 'notes'} is a file; expected a folder that can be written to" in said
    assert len(said.splitlines()) == 1
