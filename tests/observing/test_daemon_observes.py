"""The daemon's service has the model beside the antenna, and `--then` lets an effect set in."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import pytest

from firmware_protocol.documents import yaml_text
from gimbal_hil.data.runs import open_run, replay
from gimbal_hil.realtime.lockstep import give_again, host_of
from gimbal_hil.surface.cli.watch import status_lines
from tests.daemon.daemons import PATIENCE_S, RunningDaemon
from tests.sim_backend.test_observer import with_cogging

pytestmark = pytest.mark.realtime


@pytest.mark.heavy
def test_an_effect_that_sets_in_shows_in_status_and_watch_and_the_run_is_replayed(tmp_path: Path) -> None:
    (tmp_path / "cogging.yaml").write_text(yaml_text(with_cogging().document))
    run = tmp_path / "run"
    words = ("--duration", "60", "--then", f"{tmp_path / 'cogging.yaml'}@8")
    with RunningDaemon(run, *words) as daemon, daemon.client() as client:
        daemon.until_state(client, "idle")
        swing = {"mode": "position", "shape": "sine", "parameters": [0.0, 0.4, 0.2, 0.0]}
        client.when_ready("segments", segments=[{"outer": swing, "inner": swing}])
        before, after = (_rms_once(client, lambda status, at=at: status["time_ns"] >= at * 1e9) for at in (6.0, 11.0))
        answer: dict[str, Any] = client.request("status")
        client.request("shut_down")
        assert daemon.wait()[0] == 0
    assert before is not None and after is not None and before < 3e-3 < 0.01 < after
    assert any(line.startswith("beside the model: outer lacks ") for line in status_lines(answer))
    log = open_run(run)
    assert any("goes on as" in event.text for event in log.events)
    host = host_of(log)
    assert replay(log, host, lambda event: give_again(host, log, event)).identical


def _rms_once(client: Any, ready: Any) -> float | None:
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        status = client.request("status")["status"]
        if ready(status):
            found: float | None = status["observer"]["axes"]["outer"]["rms_nm"]
            return found
        time.sleep(0.05)
    raise AssertionError("it never got that far")
