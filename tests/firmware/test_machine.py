"""The C device as Cortex-M machine code leaves the frames of the Python device; its size, stack and instructions."""

from __future__ import annotations

import importlib.util
import json
import shutil
from functools import partial
from pathlib import Path

import pytest
from hypothesis import given, settings

from firmware_protocol.messages import SetPoint
from gimbal_hil.surface.cli.app import run
from sim_backend.device import Device
from sim_backend.firmware import MachineAntenna, MachineImage, build_image
from tests.device.bench import bench_model, control
from tests.device.guard_scenarios import SCENARIOS
from tests.endpoints import Sender
from tests.firmware.mutants import CMutant, MakeDevice, passes, survivors
from tests.firmware.sessions import ACTIONS, Action, random_actions, run_both

pytestmark = [
    pytest.mark.skipif(shutil.which("arm-none-eabi-gcc") is None, reason="needs apt's gcc-arm-none-eabi"),
    pytest.mark.skipif(importlib.util.find_spec("unicorn") is None, reason="needs unicorn (pip install unicorn)"),
]


@pytest.fixture(scope="module")
def image(tmp_path_factory: pytest.TempPathFactory) -> MachineImage:
    return build_image(tmp_path_factory.mktemp("image"))


@settings(max_examples=15)
@given(actions=ACTIONS)
def test_any_session_leaves_the_same_frames(image: MachineImage, actions: list[Action]) -> None:
    run_both(Device, partial(MachineAntenna, image), bench_model(), actions)


def test_so_does_a_long_session(image: MachineImage) -> None:
    pair = run_both(Device, partial(MachineAntenna, image), bench_model(), random_actions(1, 200))
    assert pair.ticks > 1000 and len(pair.states) > 5


@pytest.mark.heavy
def test_so_do_many_long_sessions(image: MachineImage) -> None:
    for seed in range(1000, 1040):
        run_both(Device, partial(MachineAntenna, image), bench_model(), random_actions(seed, 250))


@pytest.mark.parametrize("scenario", list(SCENARIOS)[::7])
def test_guards_hold_in_machine_code(scenario: str, image: MachineImage) -> None:
    assert passes(scenario, partial(MachineAntenna, image))


@pytest.mark.heavy
def test_every_guard_holds_in_machine_code_and_none_can_be_taken_out(image: MachineImage, tmp_path: Path) -> None:
    assert [name for name in SCENARIOS if not passes(name, partial(MachineAntenna, image))] == []

    def machine_of(mutant: CMutant) -> MakeDevice:
        return partial(MachineAntenna, build_image(tmp_path / "mutant", mutant.sources()))

    assert survivors(machine_of) == []


def test_a_tick_takes_some_thousand_instructions_and_little_stack(image: MachineImage) -> None:
    antenna, sender = MachineAntenna(image, bench_model(), seed=1), Sender()
    counted = []
    for k in range(120):
        block = sender.encode(control(identify=k % 10 == 0), SetPoint(1.0, -0.5, k, True, True))
        counted.append(antenna.counted_tick(block))
    instructions, stack = zip(*counted, strict=True)
    assert image.size < 10_000 and min(instructions) > 2000 and max(instructions) < 12_000
    assert 100 < max(stack) < 400


@pytest.mark.parametrize("link", ["c", "cortex-m"])
def test_the_c_device_meets_the_requirements(link: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    some = ("W-03", "F-01", "I-02", "S-02", "S-04", "S-07", "D-01", "D-05", "T-02")
    only = [word for number in some for word in ("--only", number)]
    assert run("conformance", ["--link", link, *only, "--out", str(tmp_path / "found"), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["conforms"] and document["antenna"].startswith(f"C device ({link})")


@pytest.mark.heavy
@pytest.mark.parametrize("link", ["c", "cortex-m"])
def test_the_c_device_meets_all_requirements(link: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("conformance", ["--link", link, "--out", str(tmp_path / "found")]) == 0
    assert "37 passed" in capsys.readouterr().out
