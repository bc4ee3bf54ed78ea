"""Closed streams, pipes as files, cut kernels, wrong words: one line and an exit code, never a traceback."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError, shown
from gimbal_hil.data.runs import EventKind, RunWriter, open_run
from gimbal_hil.realtime.operator import Door
from gimbal_hil.surface.cli import app
from gimbal_hil.surface.cli.app import main
from tests.parts import heavy_but
from tests.runs.synthetic import HEADER, record_run

COMMAND = f'"{sys.executable}" -c "from gimbal_hil.surface.cli import main; main()"'


@pytest.mark.parametrize("closed", heavy_but((">&-", "<&- >&- 2>&-"), ("<&-", ">&-", "2>&-", "<&- >&- 2>&-")))
def test_a_stream_that_was_closed_is_an_empty_one(closed: str, tmp_path: Path) -> None:
    done = subprocess.run(
        ["sh", "-c", f"{COMMAND} init made {closed}"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2 and "Traceback" not in done.stderr


@pytest.mark.parametrize("word", ["--install-completion", "--show-completion"])
def test_a_shell_that_nobody_knows_is_refused_in_a_line(word: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main([word, "wrongword"])
    said = capsys.readouterr().err
    assert ended.value.code == 2 and said.startswith("error: ") and said.count("\n") == 1


@pytest.mark.parametrize("words", [["check"], ["identify", "--out", "made"], ["runs", "show"], ["replay"]])
@pytest.mark.parametrize("place", ["pipe", "/dev/zero"])
def test_a_pipe_or_a_device_is_no_file(words: list[str], place: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(SystemExit) as ended:
        app.run(words[0], [*words[1:], str(tmp_path / place)])
    assert ended.value.code == 2


def test_a_cell_that_nobody_measures_is_refused_with_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "log.csv"
    rows = [f"{k * 1e-3:.3f},{1e308 if k == 500 else 0.1},{np.sin(k * 1e-3)}" for k in range(1000)]
    file.write_text("\n".join(["time_s,outer.torque,outer.position", *rows]) + "\n")
    assert app.run("check", [str(file), "--axes", "outer"]) == 1
    assert "line 502" in (said := capsys.readouterr().out) and "1e+308" in said


def test_a_socket_finds_a_short_place_where_the_runtime_folder_has_a_long_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    long = tmp_path / ("x" * 100)
    long.mkdir()
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(long))
    door = Door.make()
    assert len(os.fsencode(door.socket)) <= 107 and not door.socket.is_relative_to(long)
    door.remove(tmp_path)
    monkeypatch.setattr("tempfile.tempdir", str(long))
    with pytest.raises(BadInputError, match="too long for a socket"):
        Door.make()
    assert not list(long.iterdir())


def test_a_kernel_that_was_cut_off_is_told_with_what_to_do(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    space = {"__name__": "numba.core.caching"}
    exec("def load():\n    raise EOFError('Ran out of input')", space)
    load = space["load"]
    monkeypatch.setattr(app, "function_of", lambda name: load())  # type: ignore[operator]
    with pytest.raises(SystemExit) as ended:
        app.run("effects", [])
    assert ended.value.code == 2 and "expected the folder deleted" in capsys.readouterr().err


def test_ctrl_c_before_a_command_has_begun_is_a_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted() -> str:
        raise KeyboardInterrupt

    monkeypatch.setattr(app, "overview", interrupted)
    with pytest.raises(SystemExit) as ended:
        main(["--help"])
    assert ended.value.code == 130 and capsys.readouterr().err == "interrupted\n"


def test_no_control_character_of_a_run_reaches_the_terminal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    evil = "\033[2J\033]0;owned\a"
    header = replace(HEADER, title=f"step{evil}", model={"name": evil}, axes=("outer", f"inner{evil}"))
    record_run(tmp_path / "sound", 50)
    with RunWriter(tmp_path / "run", header) as writer:
        writer.event(1, 1_000_000, EventKind.FAULT, evil, {})
        writer.close(3, evil)
    for words in (["list", str(tmp_path)], ["show", str(tmp_path / "run")], ["compare", *[str(tmp_path / "run")] * 2]):
        with contextlib.suppress(SystemExit):
            app.run("runs", words)
        said = capsys.readouterr()
        assert "\033" not in said.out + said.err and "\a" not in said.out + said.err
    assert shown("a\033b") == "a\\x1bb"


def test_a_run_whose_gains_were_changed_says_so_wherever_it_is_read(tmp_path: Path) -> None:
    values = {"outer": {"rate_loop.kp_s_per_rad": 50.0}}
    with RunWriter(tmp_path / "run", HEADER) as writer:
        writer.command(7, 7_000_000, "adjust", {"command": "adjust", "values": values, "before": {}})
    log = open_run(tmp_path / "run")
    assert log.record.end is not None and log.record.end.adjusted == values
    assert any("changed at tick 7; in force at the end: outer.rate_loop.kp_s_per_rad 50" in note for note in log.notes)


def test_what_stands_behind_two_dashes_is_a_name(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        app.run("check", ["--", "--help"])
    said = capsys.readouterr()
    assert not said.out and "--help: no such file" in said.err
