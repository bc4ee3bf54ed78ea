"""`link.embedded.firmware` says whose firmware answers; the rest of a configuration does not notice."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from gimbal_hil.cli.app import run
from gimbal_hil.runs import open_run
from gimbal_hil.settings import EmbeddedAntenna, load_settings
from gimbal_hil.starting import settings_on_link
from gimbal_hil.testing.antennas import antenna_of
from sim_backend.firmware_run import FirmwareRun
from tests.daemon.daemons import patient_configuration

pytestmark = pytest.mark.skipif(
    shutil.which("cc") is None and shutil.which("gcc") is None, reason="needs a C compiler (apt install gcc)"
)


def configuration(folder: Path, firmware: str) -> Path:
    folder.mkdir()
    return patient_configuration(folder, {"embedded": {"model": "thesis", "seed": 4, "firmware": firmware}})


def test_the_c_device_by_configuration_leaves_the_run_of_the_virtual_antenna(tmp_path: Path) -> None:
    runs = []
    for firmware in ("virtual", "c"):
        settings = load_settings(configuration(tmp_path / firmware, firmware))
        antenna = antenna_of(settings, tmp_path / firmware / "run")
        antenna.step("inner", 0.1, for_s=0.3)
        antenna.close()
        runs.append(open_run(tmp_path / firmware / "run"))
    assert runs[0].frames.tobytes() == runs[1].frames.tobytes() and len(runs[0].frames) > 1000
    assert runs[0].ticks.tobytes() == runs[1].ticks.tobytes()


@pytest.mark.heavy
def test_so_does_a_daemon_in_lockstep(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    runs = []
    for firmware in ("virtual", "c"):
        file = configuration(tmp_path / firmware, firmware)
        words = ["--config", str(file), "--lockstep", "--duration", "1", "--out", str(tmp_path / firmware / "run")]
        assert run("daemon", words) == 0
        runs.append(open_run(tmp_path / firmware / "run"))
    capsys.readouterr()
    assert runs[0].content_hashes() == runs[1].content_hashes()


def test_a_link_named_after_a_firmware_is_the_embedded_antenna_with_it() -> None:
    for firmware in FirmwareRun:
        link = settings_on_link(None, firmware.value).link
        assert isinstance(link, EmbeddedAntenna) and link.embedded.firmware is firmware


def test_an_experiment_says_that_it_cannot_copy_a_c_device(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as refused:
        run("experiment", ["step", "--config", str(configuration(tmp_path / "c", "c")), "--out", str(tmp_path / "run")])
    assert refused.value.code == 2 and "link.embedded.firmware" in capsys.readouterr().err
