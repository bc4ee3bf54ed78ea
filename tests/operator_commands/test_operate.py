"""`set`, `stop`, `quick-stop`, `reset`, `shut-down` and `watch`: what they ask of a daemon, and what they say."""

from __future__ import annotations

import contextlib
import json
import math
import os
import socket
from pathlib import Path
from typing import Any, Self

import pytest

from gimbal_hil.realtime.operator import Door
from gimbal_hil.realtime.telemetry import trouble_of
from gimbal_hil.surface.cli import main, operate
from gimbal_hil.surface.cli.watch import _on_screen, status_lines

STATUS: dict[str, Any] = {
    "tick": 3017,
    "time_ns": 3_017_000_000,
    "host_state": "idle",
    "host_told": "idle",
    "cause": "none",
    "link": "open",
    "drive_state": "operation_enabled",
    "drive_told": "on",
    "drive_fault": "none",
    "segment": 0,
    "mode": {"pan": "position", "tilt": "off"},
    "position_rad": {"pan": 0.25, "tilt": -0.1},
    "rate_rad_s": {"pan": 0.0, "tilt": 0.0},
    "torque_nm": {"pan": 1.5, "tilt": 0.0},
    "rejected_frames": 2,
    "statistics": {
        "missed": 3,
        "missed_by_cause": {"own_computing": 0, "preemption": 3},
        "latency_us": {"p50": 21.0, "p99": 80.0, "max": 950.0},
    },
}


class Daemon:
    """Answers like the door does, and keeps what it was asked."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, dict[str, object]]] = []

    def request(self, command: str, /, **fields: object) -> dict[str, Any]:
        self.asked.append((command, fields))
        return {"ok": True, "status": STATUS} if command == "status" else {"ok": True, "tick": 3020}

    when_ready = request

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass


@pytest.fixture
def daemon(monkeypatch: pytest.MonkeyPatch) -> Daemon:
    made = Daemon()
    monkeypatch.setattr(operate, "_client", lambda folder: made)
    return made


def ask(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as end:
        main(list(words))
    said = capsys.readouterr()
    assert isinstance(end.value.code, int)
    return end.value.code, said.out, said.err


def test_an_axis_that_is_not_named_stays_where_it_is(daemon: Daemon, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = ask(capsys, "set", "pan=0.5", "--over", "2", "--run", "R")
    assert code == 0
    assert daemon.asked[-1] == (
        "set_point",
        {"mode": "position", "over_s": 2.0, "lease": False, "pan": 0.5, "tilt": -0.1},
    )
    assert "pan to 0.5 rad" in out and "next: gimbal-hil watch R" in out


def test_a_negative_value_is_a_value_and_rate_of_an_unnamed_axis_is_zero(
    daemon: Daemon, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ask(capsys, "set", "tilt=-0.3", "--mode", "rate", "--run", "R", "--json")[0] == 0
    assert daemon.asked[-1][1] == {"mode": "rate", "over_s": 0.0, "lease": False, "pan": 0.0, "tilt": -0.3}


@pytest.mark.parametrize(
    ("word", "mode", "value", "told"),
    [
        ("pan=30deg", "position", math.pi / 6, "pan to 0.5236 rad (30\u00b0)"),
        ("pan=0.5rad", "position", 0.5, "pan to 0.5 rad (28.648\u00b0)"),
        ("pan=-90deg/s", "rate", -math.pi / 2, "pan to -1.5708 rad/s (-90\u00b0/s)"),
        ("pan=1.5", "torque", 1.5, "pan to 1.5 N m,"),
    ],
)
def test_an_angle_may_be_given_in_degrees_and_is_told_in_both(
    daemon: Daemon, capsys: pytest.CaptureFixture[str], word: str, mode: str, value: float, told: str
) -> None:
    code, out, _ = ask(capsys, "set", word, "--mode", mode, "--run", "R")
    assert code == 0 and told in out
    assert daemon.asked[-1][1]["pan"] == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("pan=30deg/s",), "expected a number in rad, as in pan=0.5 or pan=30deg"),
        (("pan=30deg", "--mode", "rate"), "or pan=30deg/s"),
        (("pan=30deg", "--mode", "torque"), "expected a number in N m, as in pan=0.5"),
        (("pan=deg",), "'deg' is no number"),
        (("roll=1",), "no axis 'roll'; expected pan=VALUE tilt=VALUE"),
        (("pan=fast",), "'fast' is no number"),
        (("pan=nan",), "'nan' is no number"),
        (("pan=1", "--mode", "speed"), "no mode 'speed'"),
    ],
)
def test_what_makes_no_sense_is_refused_and_nothing_moves(
    daemon: Daemon, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], said: str
) -> None:
    code, _, err = ask(capsys, "set", *words, "--run", "R")
    assert code == 2 and said in err
    assert "set_point" not in [name for name, _ in daemon.asked]


@pytest.mark.parametrize("where", [["--run", "R"], ["R"]])
@pytest.mark.parametrize(
    ("word", "request_name"),
    [("stop", "stop"), ("quick-stop", "quick_stop"), ("reset", "fault_reset"), ("shut-down", "shut_down")],
)
def test_a_word_is_one_request(
    daemon: Daemon, capsys: pytest.CaptureFixture[str], where: list[str], word: str, request_name: str
) -> None:
    code, out, _ = ask(capsys, word, *where)
    assert code == 0 and daemon.asked == [(request_name, {})]
    next_line = next(line for line in out.splitlines() if line.startswith("next: gimbal-hil "))
    assert next_line.endswith(" R")
    assert json.loads(ask(capsys, word, *where, "--json")[1])["tick"] == 3020


@pytest.mark.parametrize("word", ["stop", "quick-stop", "reset", "shut-down"])
def test_two_daemons_at_once_are_refused_before_either_is_asked(
    daemon: Daemon, capsys: pytest.CaptureFixture[str], word: str
) -> None:
    code, _, err = ask(capsys, word, "d1", "--run", "d2")
    assert code == 2 and err == "error: --run d2: is not d1, which was given as well; expected one run folder\n"
    assert not daemon.asked
    assert ask(capsys, word, "d1", "--run", "./d1")[0] == 0 and len(daemon.asked) == 1


def test_without_a_run_the_newest_daemon_below_runs_is_meant(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, daemon: Daemon, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    code, _, err = ask(capsys, "stop")
    assert code == 2 and "no running daemon has its folder below ./runs" in err and not daemon.asked
    with contextlib.ExitStack() as listening:
        for name, seconds, alive in (("old", 1000, True), ("new", 2000, True), ("killed", 3000, False)):
            run = tmp_path / "runs" / name
            run.mkdir(parents=True)
            door = Door.make()
            listening.callback(door.remove, run)
            if alive:
                listener = listening.enter_context(socket.socket(socket.AF_UNIX, socket.SOCK_STREAM))
                listener.bind(str(door.socket))
                listener.listen()
            door.write(run)
            os.utime(run / "operator.json", (seconds, seconds))
        assert operate.daemon_run(None) == Path("runs/new")


def test_the_terminal_shows_axes_by_name_misses_by_cause_and_a_fault_above_all() -> None:
    text = "\n".join(status_lines({"status": STATUS, "recording": {"lamp": "ok", "free_mb": 1234.0}}))
    assert "pan" in text and "+0.2500 rad" in text and "+1.5000 N m" in text
    assert "missed 3 (preemption 3)" in text and "recording ok, 1234 MB free" in text
    assert "fault" not in text
    tripped = "\n".join(status_lines({"status": STATUS | {"drive_fault": "deadman"}}))
    assert "fault: deadman" in tripped


def test_no_line_is_wider_than_the_terminal_and_what_is_wrong_is_red_where_there_is_colour() -> None:
    trouble = trouble_of("fault", "runaway", "none", "phase\x1b[2J", 2.0)
    assert trouble is not None
    limits = {"pan": {"position_low_rad": -1.0, "position_high_rad": 0.5}}
    status = STATUS | {"host_state": "fault", "trouble": trouble.as_dict(), "limits": limits}
    answer = {"status": status, "recording": {"lamp": "failed", "free_mb": 1.0}}
    for columns in (60, 80, 132):
        plain = _on_screen(answer, columns, coloured=False)
        assert max(map(len, plain)) <= columns and not any("\x1b" in line for line in plain)
        coloured = _on_screen(answer, columns, coloured=True)
        red = [line for line in coloured if line.startswith("\x1b[1;31m")]
        assert all(line.endswith("\x1b[0m") for line in red) and len(coloured) == len(plain)
        text = " ".join(line.strip() for line in plain)
        assert "STOPPED for 1 s, since 2.0 s: runaway: over 30 ms the axis gains momentum" in text
        assert "look at phases and sign of the motor" in text and "to go on: gimbal-hil reset" in text
        assert any("recording failed" in line for line in red) and any("STOPPED" in line for line in red)
    text = "\n".join(status_lines(answer))
    assert "+14.324\u00b0" in text and "-57\u00b0 [" in text and "] +29\u00b0" in text and "-180\u00b0 [" in text


def test_a_position_that_nobody_has_heard_yet_is_no_number() -> None:
    unheard = STATUS | {"position_rad": {"pan": None, "tilt": None}, "drive_state": None, "drive_told": None}
    text = "\n".join(status_lines({"status": unheard}))
    assert "not heard" in text and "nan" not in text.lower()


def test_what_a_silent_drive_said_last_is_not_told_as_its_state() -> None:
    heard, lost = ("\n".join(status_lines({"status": STATUS | {"link": link}})) for link in ("ok", "lost"))
    assert "drive on, last heard" in lost and "last heard" not in heard
