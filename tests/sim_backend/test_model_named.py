"""A model is named by its file or by the name of a shipped one, wherever a command takes one."""

from __future__ import annotations

from pathlib import Path

import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.surface.cli import main
from sim_backend.model import model_named, shipped_model_path


@pytest.mark.parametrize("name", ["thesis", "emps", "realistic", "thesis-temperature"])
def test_a_shipped_name_and_its_file_are_the_same_model(name: str) -> None:
    assert model_named(name).document == model_named(shipped_model_path(name)).document


def test_a_name_that_is_none_is_refused_with_those_that_are() -> None:
    with pytest.raises(
        BadInputError, match="no shipped model 'thesys'; expected emps, realistic, thesis, thesis-temperature"
    ):
        model_named("thesys")


@pytest.mark.parametrize(
    "words",
    [
        ["experiment", "step"],
        ["identify", "LOG"],
        ["discrepancy", "--measured", "LOG"],
        ["improve"],
        ["plant", "--link", "serial"],
    ],
    ids=lambda words: words[0],
)
def test_every_command_with_a_model_takes_names(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    out = [] if words[0] == "plant" else ["--out", str(tmp_path / "out")]
    with pytest.raises(SystemExit) as end:
        main([*words, "--model", "thesys", *out])
    assert end.value.code == 2 and "no shipped model 'thesys'" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
