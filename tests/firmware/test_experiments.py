"""An experiment on the C device leaves what it leaves on the virtual antenna, also when it was stopped in its midst."""

from __future__ import annotations

import shutil
from contextlib import closing
from pathlib import Path

import pytest

from gimbal_hil.knowledge.experiments import LockstepAntenna
from gimbal_hil.knowledge.experiments.runner import Outcome, run_experiment
from gimbal_hil.loop.settings import shipped_settings
from sim_backend.firmware_run import FirmwareRun
from sim_backend.model import shipped_model
from tests.experiments.small_sequence import small_sequence
from tests.experiments.test_runner import SEED, StopAt, header, same_end

pytestmark = pytest.mark.skipif(
    shutil.which("cc") is None and shutil.which("gcc") is None, reason="needs a C compiler (apt install gcc)"
)


def needs(firmware: FirmwareRun, *tools: str) -> object:
    missing = [tool for tool in tools if shutil.which(tool) is None]
    skipped = pytest.mark.skipif(
        bool(missing), reason=f"needs apt's qemu-system-arm and gcc-arm-none-eabi: no {missing}"
    )
    return pytest.param(firmware, marks=[pytest.mark.heavy, skipped])


FIRMWARE = [
    FirmwareRun.LIBRARY,
    needs(FirmwareRun.MACHINE_CODE, "arm-none-eabi-gcc"),
    needs(FirmwareRun.BOARD, "arm-none-eabi-gcc", "qemu-system-arm"),
]


def made(firmware: FirmwareRun, folder: Path, stop: StopAt | None = None, resume: bool = False) -> Outcome:
    with closing(LockstepAntenna(shipped_settings(), shipped_model(), SEED, firmware=firmware)) as antenna:
        return run_experiment(small_sequence(), antenna, folder, header(), progress=stop, resume=resume)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Outcome:
    """The sequence on the virtual antenna's own firmware."""
    return made(FirmwareRun.VIRTUAL, tmp_path_factory.mktemp("whole"))


@pytest.mark.parametrize("firmware", FIRMWARE)
def test_a_sequence_that_was_stopped_and_resumed_ends_as_on_the_virtual_antenna(
    firmware: FirmwareRun, tmp_path: Path, whole: Outcome
) -> None:
    with pytest.raises(KeyboardInterrupt):
        made(firmware, tmp_path, StopAt(small_sequence().steps[2].name, KeyboardInterrupt()))
    same_end(made(firmware, tmp_path, resume=True), whole)
