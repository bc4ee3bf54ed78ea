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

from gimbal_hil.data.runs import open_run
from gimbal_hil.realtime.operator.client import OperatorClient
from gimbal_hil.surface.cli.app import run as run_command
from tests.daemon.daemons import PATIENCE_S, Json, RunningDaemon, patient_configuration
from tests.parts import heavy_but

pytestmark = pytest.mark.realtime

HALF_S = float(os.environ.get("GIMBAL_HIL_SCENARIO_S", "3"))
LONGEST_HALF_S = HALF_S + 60.0
AT_PLACE_RAD = 0.02
PORT = "antenna"
LINKS: dict[str, Json] = {
    "serial": {"kind": "serial", "port": PORT},
    "slcan": {"kind": "can", "interface": "slcan", "channel": PORT},
    "unix": {"kind": "unix", "path": PORT},
}


def configuration(folder: Path, kind: str, first_test: str = "never") -> Path:
    link = {key: str(folder / PORT) if value == PORT else value for key, value in LINKS[kind].items()}
    return patient_configuration(folder, link, first_test=first_test)


class RunningPlant:
    """`gimbal-hil plant` until it is told to go."""

    def __init__(self, folder: Path, kind: str) -> None:
        words = ["plant", "--link", f"{kind}:{folder / PORT}", "--json", "--ready-file", str(folder / "ready")]
        self.process = subprocess.Popen(
            [sys.executable, "-c", "from gimbal_hil.surface.cli import main; main()", *words],
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


@pytest.mark.heavy
@pytest.mark.parametrize("kind", heavy_but(("unix",), LINKS))
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


@pytest.mark.parametrize("kind", heavy_but(("unix",), ("serial", "unix")))
def test_the_first_test_passes_over_a_real_driver_stack_before_anything_else_moves(
    tmp_path: Path, plants: list[RunningPlant], kind: str
) -> None:
    run, config = tmp_path / "run", configuration(tmp_path, kind, first_test="real_link")
    plants.append(RunningPlant(tmp_path, kind))
    with RunningDaemon(run, "--config", str(config)) as daemon, daemon.client() as client:
        # what is asked before is put off, and not refused for good
        client.when_ready("set_point", timeout_s=PATIENCE_S, mode="position", outer=0.1, inner=0.1)
        daemon.until_state(client, "active")
        client.request("shut_down")
        code, answer, _ = daemon.wait()
    assert (code, answer["reason"]) == (0, "shut down by the operator")
    log = open_run(run)
    passed = [event.tick for event in log.events if "first test: each axis turns" in event.text]
    starts = [event.tick for event in log.commands() if event.data["command"] == "start"]
    # its own programs (more than one where the machine stalled), and then the operator's
    assert len(passed) == 1 and len(starts) >= 2
    assert starts[0] < passed[0] <= starts[-1] and not any(passed[0] < tick < starts[-1] for tick in starts)
    assert run_command("replay", [str(run), "--json"]) == 0


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
