"""`link.embedded.firmware` says whose firmware answers; the rest of a configuration does not notice."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from firmware_protocol.enumerations import DriveRequest, DriveState
from firmware_protocol.messages import SetPoint
from gimbal_hil.data.runs import open_run
from gimbal_hil.loop.settings import EmbeddedAntenna, load_settings
from gimbal_hil.realtime.daemon.antenna_link import EmbeddedLink
from gimbal_hil.surface.cli.app import run
from gimbal_hil.surface.starting import settings_on_link
from gimbal_hil.surface.testing.antennas import antenna_of
from sim_backend.firmware import run_firmware
from sim_backend.firmware_run import FirmwareRun
from sim_backend.model import shipped_model
from tests.daemon.daemons import patient_configuration
from tests.device.bench import control
from tests.endpoints import Sender

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


def test_an_effect_sets_in_on_the_c_device_as_on_the_virtual_antenna() -> None:
    """As `daemon --then`: from a tick on the antenna is another, in the motion that it had."""
    later = shipped_model().with_effect("cogging", "outer", {"amplitude": 0.5, "order": 12.0})
    answers = []
    for firmware in (FirmwareRun.VIRTUAL, FirmwareRun.LIBRARY):
        link = EmbeddedLink(run_firmware(firmware, shipped_model(), 1000.0, 4))
        link.becomes(run_firmware(firmware, later, 1000.0, 4), 60, lambda told: None)
        sender = Sender()
        requests = {20: DriveRequest.SHUTDOWN, 30: DriveRequest.SWITCH_ON, 40: DriveRequest.ENABLE_OPERATION}
        for tick in range(200):
            others = [control(requests[tick])] if tick in requests else []
            link.send(sender.encode(*others, SetPoint(2.0, 0.5, tick, True, True)))
        assert link.device.model is later and link.device.state is DriveState.OPERATION_ENABLED
        answers.append((link.receive(), link.device.X.tobytes()))
    assert answers[0] == answers[1]


def test_a_link_named_after_a_firmware_is_the_embedded_antenna_with_it() -> None:
    for firmware in FirmwareRun:
        link = settings_on_link(None, firmware.value).link
        assert isinstance(link, EmbeddedAntenna) and link.embedded.firmware is firmware


def test_an_experiment_on_the_c_device_says_so_and_has_the_table_of_the_virtual_antenna(tmp_path: Path) -> None:
    for firmware in ("virtual", "c"):
        words = ["step", "--short", "--axis", "inner", "--config", str(configuration(tmp_path / firmware, firmware))]
        assert run("experiment", [*words, "--out", str(tmp_path / firmware / "run"), "--json"]) == 0
    of_virtual, of_c = (tmp_path / firmware / "run" for firmware in ("virtual", "c"))
    assert (of_virtual / "table.csv").read_bytes() == (of_c / "table.csv").read_bytes()
    assert "C device (c) with antenna thesis" in (of_c / "report.html").read_text()
    assert "C device" not in (of_virtual / "report.html").read_text()
