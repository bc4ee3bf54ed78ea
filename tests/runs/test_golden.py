"""Golden runs: a host that was changed on purpose, what changed told signal by signal, and the reference updated."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.documents import yaml_text
from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import TICK_ROW, RecordedRun, changes, open_run, replay, run_again, update
from gimbal_hil.realtime.lockstep import give_again, host_of
from gimbal_hil.surface.cli import app
from tests.runs.lockstep import record_lockstep

TICKS, FROM = 1200, 700


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("golden") / "run"
    record_lockstep(folder, TICKS)
    return folder


@pytest.fixture
def copy(recorded: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(recorded, tmp_path / "copy"))


class Changed:
    """The host with another torque in its rows, and one byte of the first frame it sends turned, from a tick on."""

    def __init__(self, run: RecordedRun) -> None:
        self._host = host_of(run)
        self._tick = 0

    def __getattr__(self, name: str) -> object:
        return getattr(self._host, name)

    def tick(self, tick: int, time_ns: int, received: bytes) -> bytes:
        self._tick = tick
        sent = bytearray(self._host.tick(tick, time_ns, received))
        if tick >= FROM and sent:
            sent[2] ^= 1
        return bytes(sent)

    @property
    def row(self) -> bytes:
        row = np.frombuffer(self._host.row, TICK_ROW).copy()
        if self._tick >= FROM:
            row["torque_inner"] += 0.25
        return row.tobytes()


def result_of(folder: Path, build: Callable[[RecordedRun], object]) -> bool:
    run = open_run(folder)
    host = build(run)
    return replay(run, host, lambda event: give_again(host, run, event)).identical  # type: ignore[arg-type]


def test_a_host_that_was_not_changed_changes_nothing(recorded: Path) -> None:
    run = open_run(recorded)
    host = host_of(run)
    assert changes(run, run_again(run, host, lambda event: give_again(host, run, event))) == []


def test_what_changed_is_told_signal_by_signal_and_the_update_holds(copy: Path) -> None:
    (copy / "report.html").write_text("kept")
    run = open_run(copy)
    host = Changed(run)
    again = run_again(run, host, lambda event: give_again(host, run, event))  # type: ignore[arg-type]
    found = {change.signal: change for change in changes(run, again)}
    torque = found.pop("torque_inner")
    assert (torque.ticks, torque.first_tick) == (TICKS - FROM, FROM)
    assert torque.largest == pytest.approx(0.25)
    assert torque.in_words(TICKS) == "torque_inner: at 500 of 1200 ticks, from tick 700 on, by 0.25 at most, 0.161 rms"
    assert found and all(name.startswith("frame sent, ") for name in found)
    update(run, again)
    new = open_run(copy)
    assert [(e.tick, e.kind, e.text) for e in new.events] == [(e.tick, e.kind, e.text) for e in run.events]
    assert new.record.header == run.record.header and (copy / "report.html").read_text() == "kept"
    assert result_of(copy, Changed) and not result_of(copy, host_of)
    assert sorted(path.name for path in copy.parent.iterdir()) == ["copy"]


def test_the_command_tells_updates_and_is_content_afterwards(
    copy: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("gimbal_hil.realtime.lockstep.host_of", Changed)
    assert app.run("replay", [str(copy)]) == 1
    said = capsys.readouterr().out
    assert "differs at tick 700" in said and "torque_inner: at 500 of 1200 ticks" in said
    assert app.run("replay", [str(copy), "--update", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["updated"] and answer["changes"][0]["signal"] == "torque_inner"
    assert app.run("replay", [str(copy)]) == 0
    assert "identical" in capsys.readouterr().out


def test_another_configuration_shows_what_it_would_have_sent(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    document = dict(open_run(recorded).record.header.configuration)
    same, other, faster = (tmp_path / f"{name}.yaml" for name in ("same", "other", "faster"))
    same.write_text(yaml_text(document))
    assert app.run("replay", [str(recorded), "--config", str(same)]) == 0
    capsys.readouterr()
    document["axes"]["inner"]["rate_loop"]["kp_s_per_rad"] *= 1.5
    other.write_text(yaml_text(document))
    before = open_run(recorded).content_hashes()
    assert app.run("replay", [str(recorded), "--config", str(other), "--json"]) == 1
    told = {change["signal"]: change for change in json.loads(capsys.readouterr().out)["changes"]}
    assert "torque_inner" in told and "torque_outer" not in told
    assert open_run(recorded).content_hashes() == before
    faster.write_text(yaml_text(document | {"rate_hz": 500.0}))
    for words, said in ((("--config", str(faster)), "rate_hz"), (("--config", str(other), "--update"), "--update")):
        with pytest.raises(SystemExit, match="2"):
            app.run("replay", [str(recorded), *words])
        assert said in capsys.readouterr().err


def test_a_damaged_run_is_no_reference(copy: Path) -> None:
    data = bytearray((copy / "frames.arrow").read_bytes())
    data[len(data) // 2] ^= 0x10
    (copy / "frames.arrow").write_bytes(bytes(data))
    run = open_run(copy)
    host = host_of(run)
    with pytest.raises(BadInputError, match="cannot be a reference"):
        run_again(run, host, lambda event: give_again(host, run, event))
