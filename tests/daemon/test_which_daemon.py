"""Without `--run` a command means the newest daemon that is alive."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.realtime.operator import Door, OperatorSocket
from gimbal_hil.surface.cli.operate import daemon_run


def door_in(folder: Path, age_s: float) -> Door:
    folder.mkdir(parents=True)
    door = Door.make()
    file = door.write(folder)
    os.utime(file, (1e9 - age_s, 1e9 - age_s))
    return door


def test_a_stop_goes_to_the_daemon_that_listens_and_not_to_a_newer_door_that_is_dead(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    doors = {name: door_in(Path("runs") / name, age) for name, age in (("old", 30.0), ("alive", 20.0), ("dead", 10.0))}
    broken = Path("runs/broken")
    broken.mkdir()
    (broken / "operator.json").write_text(json.dumps({"socket": 7}))
    listening = [OperatorSocket(doors[name], lambda client, request: None) for name in ("old", "alive")]
    try:
        assert daemon_run(None) == Path("runs/alive")
        assert daemon_run(Path("runs/dead")) == Path("runs/dead")
    finally:
        for one in listening:
            one.close()
    with pytest.raises(BadInputError, match="no running daemon has its folder below"):
        daemon_run(None)
    for name, door in doors.items():
        door.remove(Path("runs") / name)
