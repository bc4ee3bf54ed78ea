"""The image of a whole board in QEMU: the frames of the Python device, judged and controlled over its UART."""

from __future__ import annotations

import json
import shutil
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import open_run
from gimbal_hil.loop.host import AxisCommand, Mode, Segment, Shape, program_of
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.proof.bench.faults import Transport, fault_rows, run_row
from gimbal_hil.realtime.operator import OperatorClient
from gimbal_hil.surface.cli.app import run
from gimbal_hil.surface.testing.recorded import RecordedSignals
from sim_backend.device import Device
from sim_backend.firmware import BoardAntenna, BoardImage, build_board
from sim_backend.firmware_run import FirmwareRun
from sim_backend.model import AntennaModel, shipped_model
from tests.daemon.daemons import RunningDaemon, patient_configuration
from tests.device.bench import bench_model
from tests.device.guard_scenarios import SCENARIOS
from tests.firmware.mutants import passes, survivors
from tests.firmware.sessions import Pair, random_actions

MISSING = [tool for tool in ("qemu-system-arm", "arm-none-eabi-gcc") if shutil.which(tool) is None]
needs_board = pytest.mark.skipif(
    bool(MISSING), reason=f"needs apt's qemu-system-arm and gcc-arm-none-eabi: no {MISSING}"
)
pytestmark = pytest.mark.realtime


@pytest.fixture(scope="module")
def image(tmp_path_factory: pytest.TempPathFactory) -> BoardImage:
    return build_board(tmp_path_factory.mktemp("board"))


@contextmanager
def board(image: BoardImage, model: AntennaModel, seed: int = 1) -> Iterator[BoardAntenna]:
    antenna = BoardAntenna(image, model, seed=seed)
    try:
        yield antenna
    finally:
        antenna.close()


def same_session(image: BoardImage, seed: int, count: int) -> Pair:
    """Both through random actions."""
    with board(image, bench_model(), 5) as other:
        pair = Pair(Device(bench_model(), seed=5), other)
        for action in random_actions(seed, count):
            pair.act(action)
        pair.tick()
        assert pair.both[0].X.tobytes() == pair.both[1].X.tobytes()
        assert (other.state, other.fault) == (pair.both[0].state, pair.both[0].fault)
        assert (other.set_points, other.torques_nm) == (pair.both[0].set_points, pair.both[0].torques_nm)
    return pair


@needs_board
def test_a_session_leaves_the_frames_of_the_device_and_the_same_motion(image: BoardImage) -> None:
    assert same_session(image, 3, 12).ticks > 50


@needs_board
@pytest.mark.heavy
def test_so_do_long_sessions(image: BoardImage) -> None:
    for seed in range(2000, 2005):
        assert same_session(image, seed, 250).ticks > 1000


@needs_board
@pytest.mark.parametrize("scenario", list(SCENARIOS)[::17])
def test_guards_hold_on_the_board(scenario: str, image: BoardImage) -> None:
    assert passes(scenario, partial(BoardAntenna, image))


@needs_board
@pytest.mark.heavy
def test_every_guard_holds_on_the_board(image: BoardImage) -> None:
    assert [name for name in SCENARIOS if not passes(name, partial(BoardAntenna, image))] == []


@needs_board
@pytest.mark.heavy
def test_no_guard_can_be_taken_out_of_the_board(tmp_path: Path) -> None:
    assert survivors(lambda mutant: partial(BoardAntenna, build_board(tmp_path, mutant.sources()))) == []


@needs_board
def test_some_requirements_are_met(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    only = [word for number in ("I-02", "S-03", "D-01", "D-02", "T-02") for word in ("--only", number)]
    assert run("conformance", ["--link", "qemu", "--out", str(tmp_path / "found"), "--json", *only]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["antenna"] == "C device (qemu) with antenna thesis" and len(found["findings"]) == 5


@needs_board
@pytest.mark.heavy
def test_every_requirement_is_met(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("conformance", ["--link", "qemu", "--out", str(tmp_path / "found"), "--json"]) == 0
    assert {one["verdict"] for one in json.loads(capsys.readouterr().out)["findings"]} == {"passed"}


@needs_board
@pytest.mark.heavy
def test_a_sample_of_the_fault_matrix_ends_safely() -> None:
    for row in fault_rows()[3::42]:
        found = run_row(row, shipped_settings(), shipped_model(), Transport.SERIAL, FirmwareRun.BOARD)
        assert found.problem == "", found


@needs_board
@pytest.mark.heavy
def test_the_daemon_steps_both_axes_over_the_boards_uart(image: BoardImage, tmp_path: Path) -> None:
    with board(image, shipped_model()) as served:
        configuration = patient_configuration(tmp_path, {"kind": "serial", "port": served.port})
        done = threading.Event()
        plant = threading.Thread(target=lambda: [served.serve(0.05) for _ in iter(done.is_set, True)], daemon=True)
        plant.start()
        words = ("--config", str(configuration), "--lockstep", "--answer-within", "300")
        with RunningDaemon(tmp_path / "run", *words) as daemon:
            client = daemon.client()
            daemon.until_state(client, "idle")
            client.start(program_of([Segment(*(AxisCommand(Mode.POSITION, Shape.HOLD, (x,)) for x in (0.2, -0.1)))]))
            _until_s(client, 3.0)
            client.request("shut_down")
            code, answer, said = daemon.wait()
        done.set()
        plant.join(10.0)
    assert code == 0, (answer, said)
    assert open_run(tmp_path / "run").record.header.lockstep
    signals = RecordedSignals(tmp_path / "run")
    for axis, target in (("outer", 0.2), ("inner", -0.1)):
        there = np.abs(signals.signal(f"{axis}.position").values - target) < 0.003
        # for a second on end, before it was shut down
        assert np.convolve(there, np.ones(1000), "valid").max() == 1000


def _until_s(client: OperatorClient, antenna_s: float) -> None:
    """So much of the antenna's time."""
    began = client.request("status")["status"]["tick"]
    while client.request("status")["status"]["tick"] - began < 1000 * antenna_s:
        time.sleep(0.1)


def test_a_missing_tool_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", "")
    with pytest.raises(BadInputError, match="qemu-system-arm"):
        BoardAntenna(BoardImage(b"", {}), shipped_model())
    with pytest.raises(BadInputError, match="gcc-arm-none-eabi"):
        build_board(tmp_path)
