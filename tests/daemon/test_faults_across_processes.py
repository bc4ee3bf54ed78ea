"""Rows of the fault matrix with the antenna in a process of its own, over a socket and a pseudo-terminal."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from gimbal_hil.data.runs import columns_of, open_run
from gimbal_hil.realtime.operator.client import OperatorClient
from gimbal_hil.surface.cli.app import run as run_command
from tests.daemon.daemons import Json, RunningDaemon, patient_configuration

pytestmark = pytest.mark.realtime

PLANT = """
import signal, sys
from pathlib import Path
from gimbal_hil.loop.timing import control_and_witness_cores, real_time
from sim_backend.device import Device, Spoilt
from sim_backend.model import shipped_model
from sim_backend.server import DeviceServer, OutletKind, open_outlet

place, kind, part, fault = sys.argv[1:]
Device(shipped_model(), rate_hz=1000.0).tick()
device = Device(shipped_model(), rate_hz=1000.0)
outlet = open_outlet(OutletKind(kind), Path(place))
server = DeviceServer(device, outlet.link)
signal.signal(signal.SIGUSR1, lambda *_: device.spoil(0, part, Spoilt[fault]))
signal.signal(signal.SIGTERM, lambda *_: server.stop())
print("ready", flush=True)
with real_time(priority=55, core=control_and_witness_cores()[1]):
    server.serve()
outlet.link.close()
"""
#: causes by which the host may tell each fault first, and the drive's own guards
SEEN_AS = {
    ("encoder", "REVERSED"): {"sensor_drift", "gyro_encoder_disagree", "drive_fault"},
    ("encoder", "FROZEN"): {"sensor_drift", "gyro_encoder_disagree", "drive_fault"},
    ("gyro", "DEAD"): {"sensor_drift", "gyro_encoder_disagree", "runaway", "overspeed", "drive_fault"},
    ("motor", "REVERSED"): {"runaway", "drive_fault", "sensor_drift"},
}
#: faults that a stall of the machine brings
OF_THE_MACHINE = {"feedback_lost", "set_point_lost"}
#: slow, because a virtual antenna that the machine keeps from its ticks lags behind its own gyro by that share
RATE_RAD_S = 0.1
#: the matrix travels 0.08 rad in its slow rows; a busy machine gets half a second more
FURTHEST_RAD = 0.08 + 0.5 * RATE_RAD_S


@contextmanager
def plant_that_breaks(folder: Path, kind: str, part: str, fault: str) -> Iterator[subprocess.Popen[str]]:
    words = [sys.executable, "-c", PLANT, str(folder / "antenna"), kind, part, fault]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None and process.stdout.readline() == "ready\n"
        yield process
    finally:
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)


def turn(daemon: RunningDaemon, client: OperatorClient) -> Json:
    """The outer axis turns evenly; a stall of the machine meanwhile is got over."""
    for _ in range(20):
        if daemon.until_state(client, "idle", "fault")["host_state"] == "fault":
            client.request("fault_reset")
            time.sleep(0.2)
            continue
        client.when_ready(
            "segments",
            timeout_s=60.0,
            segments=[
                {
                    "outer": {"mode": "rate", "parameters": [RATE_RAD_S]},
                    "inner": {"mode": "position", "origin": "start"},
                }
            ],
        )
        time.sleep(1.0)
        status: Json = client.request("status")["status"]
        if status["host_state"] == "active":
            return status
    raise AssertionError(f"did not turn: {status['cause']}")


@pytest.mark.heavy
@pytest.mark.parametrize("kind", ["unix", "serial"])
@pytest.mark.parametrize(("part", "fault"), list(SEEN_AS))
def test_a_fault_of_an_antenna_in_another_process_stops_it_within_reach(
    tmp_path: Path, kind: str, part: str, fault: str
) -> None:
    run, port = tmp_path / "run", str(tmp_path / "antenna")
    link: Json = {"kind": kind, **({"path": port} if kind == "unix" else {"port": port})}
    config = patient_configuration(tmp_path, link, first_test="never")
    with (
        plant_that_breaks(tmp_path, kind, part, fault) as plant,
        RunningDaemon(run, "--config", str(config)) as daemon,
        daemon.client() as client,
    ):
        broken = turn(daemon, client)
        plant.send_signal(signal.SIGUSR1)
        status = daemon.until_state(client, "fault")
        time.sleep(1.0)
        client.request("shut_down")
        daemon.wait()
    assert status["cause"] in SEEN_AS[part, fault] | OF_THE_MACHINE
    log = open_run(run)
    after = log.ticks["tick"] > status["tick"]
    assert not log.ticks["torque_outer"][after].any()
    feedback = columns_of(log.frames, "feedback_outer")
    position, rate = feedback.physical("position"), feedback.physical("rate")
    # by the sensor that is whole; the base stands still
    turned = np.cumsum(rate * np.diff(feedback.tick, prepend=feedback.tick[0]) * 1e-3)
    way = (turned if part == "encoder" else position)[feedback.tick > broken["tick"]]
    assert np.abs(way - way[0]).max() < FURTHEST_RAD
    assert run_command("replay", [str(run), "--json"]) == 0
