from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import yaml

from gimbal_hil.loop.settings import shipped_settings_path
from gimbal_hil.surface.cli.app import main
from tests.daemon.daemons import RunningDaemon

pytestmark = pytest.mark.realtime


def ended(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str]:
    """Exit code and standard error of a command."""
    with pytest.raises(SystemExit) as ending:
        main(list(words))
    assert isinstance(ending.value.code, int)
    return ending.value.code, capsys.readouterr().err


def configuration(folder: Path, link: dict[str, Any], **more: Any) -> Path:
    document = yaml.safe_load(shipped_settings_path().read_text())
    path = folder / "daemon.yaml"
    path.write_text(yaml.safe_dump(document | {"link": link} | more))
    return path


@pytest.mark.parametrize(
    ("link", "words"),
    [
        ({"kind": "serial", "port": "/dev/ttyNotThere0"}, "no such port"),
        ({"kind": "serial", "port": "{folder}/nowhere/antenna"}, "no such port"),
        ({"kind": "unix", "path": "{folder}/nowhere/socket"}, "no such socket"),
        ({"kind": "can", "interface": "nobus", "channel": "can0"}, "nobus"),
        ({"kind": "can", "interface": "socketcan", "channel": "nocan0"}, "nocan0"),
        ({"kind": "can", "interface": "virtual", "channel": "a", "bitrate": 125_000}, "rate_hz"),
        ({"embedded": {"model": "{folder}/missing.yaml"}}, "missing.yaml"),
    ],
)
def test_a_link_that_cannot_be_is_one_line_exit_code_2_and_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], link: dict[str, Any], words: str
) -> None:
    filled = json.loads(json.dumps(link).replace("{folder}", str(tmp_path)))
    run = tmp_path / "run"
    code, error = ended(
        capsys, "daemon", "--config", str(configuration(tmp_path, filled)), "--out", str(run), "--duration", "1"
    )
    assert code == 2
    lines = error.strip().splitlines()
    assert len(lines) == 1 and lines[0].startswith("error: ") and words in lines[0]
    assert not run.exists()


def test_a_word_to_a_daemon_that_is_not_there_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert ended(capsys, "daemon", "--send", '{"command": "status"}')[0] == 2
    code, error = ended(capsys, "daemon", "--send", '{"command": "status"}', "--run", str(tmp_path))
    assert code == 2 and "operator.json" in error
    for text in ("nonsense", "[1]", "{}"):
        code, error = ended(capsys, "daemon", "--send", text, "--run", str(tmp_path))
        assert code == 2 and "--send" in error


def test_one_word_from_the_command_line_reaches_the_daemon(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with RunningDaemon(tmp_path / "run") as daemon:
        with daemon.client() as client:
            daemon.until_state(client, "idle")
        for request, expected in [
            ({"command": "set_point", "mode": "position", "outer": 0.1, "over_s": 0.5}, 0),
            ({"command": "set_point", "mode": "nowhere"}, 1),
            ({"command": "shut_down"}, 0),
        ]:
            with pytest.raises(SystemExit) as ending:
                main(["daemon", "--send", json.dumps(request), "--run", str(tmp_path / "run")])
            answer = json.loads(capsys.readouterr().out)
            assert ending.value.code == expected and answer["ok"] is (expected == 0)
        assert daemon.wait()[0] == 0


def test_an_antenna_that_never_answers_is_exit_code_1(tmp_path: Path) -> None:
    config = configuration(tmp_path, {"kind": "unix", "path": str(tmp_path / "socket")})
    with RunningDaemon(tmp_path / "run", "--config", str(config), "--duration", "0.5") as daemon:
        code, answer, error = daemon.wait()
    assert code == 1 and answer["reason"] == "the antenna did not answer"
    assert "waiting for the link" in error
