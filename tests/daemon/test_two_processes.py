"""The antenna and the daemon as two processes over a real driver stack: a step on both axes, the antenna killed and
started again.

`GIMBAL_HIL_SCENARIO_S` sets how long each half runs (seconds, default 3).
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import yaml

from gimbal_hil.cli.app import run as run_command
from gimbal_hil.operator.client import OperatorClient
from gimbal_hil.runs import open_run
from gimbal_hil.settings import shipped_settings_path
from tests.daemon.daemons import Json, RunningDaemon

HALF_S = float(os.environ.get("GIMBAL_HIL_SCENARIO_S", "3"))
LONGEST_HALF_S = HALF_S + 60.0
AT_PLACE_RAD = 0.02
PORT = "antenna"
LINKS: dict[str, Json] = {
    "serial": {"kind": "serial", "port": PORT},
    "slcan": {"kind": "can", "interface": "slcan", "channel": PORT},
    "unix": {"kind": "unix", "path": PORT},
}


def configuration(folder: Path, kind: str) -> Path:
    document = yaml.safe_load(shipped_settings_path().read_text())
    document["link"] = {key: str(folder / PORT) if value == PORT else value for key, value in LINKS[kind].items()}
    # a shared machine stalls for tens of milliseconds; how long a stall may be is the owner's choice and not what is
    # tested here
    document["supervisor"] |= {
        "lost_ticks": 100,
        "set_point_lag_ticks": 200,
        "deadman": {"window_ticks": 250, "reaction": "decelerate_and_hold"},
        # the test before the first motion may be unable to tell on such a machine; it has tests of its own
        "first_test": "never",
    }
    path = folder / "daemon.yaml"
    path.write_text(yaml.safe_dump(document))
    return path


class RunningPlant:
    """`gimbal-hil plant` until it is told to go."""

    def __init__(self, folder: Path, kind: str) -> None:
        words = ["plant", "--link", f"{kind}:{folder / PORT}", "--json", "--ready-file", str(folder / "ready")]
        self.process = subprocess.Popen(
            [sys.executable, "-c", "from gimbal_hil.cli import main; main()", *words],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        assert self.process.stdout and json.loads(self.process.stdout.readline())["event"] == "ready"

    def end(self, number: signal.Signals) -> Json:
        self.process.send_signal(number)
        out, _ = self.process.communicate(timeout=60)
        answer: Json = json.loads(out) if out.strip() else {}
        return answer


@pytest.fixture
def plants() -> Iterator[list[RunningPlant]]:
    started: list[RunningPlant] = []
    yield started
    for plant in started:
        if plant.process.poll() is None:
            plant.process.kill()
            plant.process.communicate()


@pytest.mark.realtime
@pytest.mark.parametrize("kind", list(LINKS))
def test_a_step_over_a_real_driver_stack_and_an_antenna_that_goes_away_and_comes_back(
    tmp_path: Path, plants: list[RunningPlant], kind: str
) -> None:
    run = tmp_path / "run"
    with RunningDaemon(run, "--config", str(configuration(tmp_path, kind))) as daemon, daemon.client() as client:
        assert daemon.until_state(client, "waiting")["link"] == "lost"
        plants.append(RunningPlant(tmp_path, kind))
        step(daemon, client, 0.5, -0.3)
        plants[0].end(signal.SIGKILL)
        assert not any(daemon.until_state(client, "fault", "waiting")["torque_nm"].values())
        plants.append(RunningPlant(tmp_path, kind))
        step(daemon, client, 0.2, 0.1)
        client.request("shut_down")
        code, answer, err = daemon.wait()
        served = plants[1].end(signal.SIGTERM)
    print(json.dumps({"link": kind, "daemon": answer, "plant": served}, indent=1))
    assert code == 0
    assert "waiting for the link" in err
    # bytes are not lost on a pseudo-terminal or a socket, so every frame that came has to be good, and every frame that
    # went
    assert not any(answer["frames"][bad] for bad in ("crc_errors", "out_of_range", "foreign"))
    assert served["bad_frames"] == 0
    assert run_command("replay", [str(run), "--json"]) == 0
    assert_stopped_while_the_antenna_was_away(run)


def step(daemon: RunningDaemon, client: OperatorClient, outer: float, inner: float) -> None:
    """Both axes to a position, for HALF_S altogether and until they are there.

    A stall beyond the limits above interrupts the step, and it is taken up again: how long the way takes then depends
    on the machine.
    """
    held_s, interruptions, off_rad = 0.0, 0, float("inf")
    while (held_s < HALF_S or off_rad > AT_PLACE_RAD) and held_s < LONGEST_HALF_S and interruptions < 50:
        status = daemon.until_state(client, "idle", "fault")
        if status["host_state"] == "fault":
            interruptions += 1
            time.sleep(0.5)
            if client.request("status")["status"]["host_state"] == "fault":
                client.request("fault_reset")
            continue
        client.when_ready("set_point", mode="position", outer=outer, inner=inner)
        began = time.monotonic()
        while time.monotonic() - began < HALF_S and status["host_state"] in ("active", "idle"):
            time.sleep(0.02)
            status = client.request("status")["status"]
        held_s += time.monotonic() - began
        place = status["position_rad"]
        off_rad = max(abs(place["outer"] - outer), abs(place["inner"] - inner))
    print(f"step to {outer}, {inner}: {off_rad} rad off after {held_s:.1f} s, interrupted {interruptions} times")
    assert off_rad < AT_PLACE_RAD


def assert_stopped_while_the_antenna_was_away(run: Path) -> None:
    rows = open_run(run).ticks
    lost = rows["link_status"] == 0
    assert lost.any()
    assert not rows["torque_outer"][lost].any() and not rows["torque_inner"][lost].any()
    assert np.abs(rows["torque_outer"]).max() > 0.0
