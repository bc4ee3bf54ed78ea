from __future__ import annotations

import json
import threading
from pathlib import Path

import pytest
import yaml

from gimbal_hil.loop.settings import DaemonSettings, settings_from_document, shipped_settings, shipped_settings_path
from gimbal_hil.realtime.daemon.link_check import check_link
from gimbal_hil.surface.cli.app import run as run_command
from sim_backend.device import Device
from sim_backend.model import shipped_model

pytestmark = pytest.mark.realtime


def settings_with(link: dict[str, object]) -> DaemonSettings:
    document = yaml.safe_load(shipped_settings_path().read_text())
    document["link"] = link
    return settings_from_document(document, "test")


def test_doctor_answers_with_a_verdict_and_its_reasons(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code = run_command("doctor", ["--seconds", "0.3", "--json", "--out", str(tmp_path)])
    answer = json.loads(capsys.readouterr().out)
    assert code == (0 if answer["holds"] else 1)
    assert answer["holds"] is (not answer["machine"]["reasons"] and not answer["link"]["reasons"])
    assert json.loads((tmp_path / "doctor.json").read_text()) == answer
    assert {"tick_loop", "c_loop", "machine_stalls", "granted", "clock", "default_timer_slack_ns"} <= set(
        answer["machine"]
    )


def test_doctor_for_people_ends_with_the_verdict_and_the_next_command(capsys: pytest.CaptureFixture[str]) -> None:
    code = run_command("doctor", ["--seconds", "0.3"])
    lines = capsys.readouterr().out.splitlines()
    verdict = next(place for place, line in enumerate(lines) if line.startswith("verdict: "))
    *reasons, following = lines[verdict + 1 :]
    assert all(line.startswith("  - ") for line in reasons)
    assert bool(reasons) is (code == 1)
    assert following.startswith("next: gimbal-hil daemon ")


def test_the_verdict_tells_the_machine_from_what_is_at_its_link(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    document = yaml.safe_load(shipped_settings_path().read_text())
    document["link"] = {"kind": "serial", "port": str(tmp_path / "nothing")}
    config = tmp_path / "antenna.yaml"
    config.write_text(yaml.safe_dump(document))
    assert run_command("doctor", ["--seconds", "0.3", "--config", str(config)]) == 1
    lines = capsys.readouterr().out.splitlines()
    (verdict,) = (line for line in lines if line.startswith("verdict: "))
    machine = " can hold the rate, but " if "no such port" in lines[lines.index(verdict) + 1] else " relied on, and "
    assert machine in verdict and verdict.endswith("the antenna does not answer as it should")
    assert lines[-1] == f"next: gimbal-hil doctor --config {config}"


def test_an_antenna_that_answers_is_told_from_a_port_that_is_open_and_silent(tmp_path: Path) -> None:
    from firmware_protocol.links import pty_link

    antenna, path = pty_link()
    silent = check_link(settings_with({"kind": "serial", "port": path}))
    assert not silent.good and "no antenna answered" in silent.reasons[0]
    device, over = Device(shipped_model()), threading.Event()
    device.tick()  # compiled before the check listens

    def speak() -> None:
        while not over.wait(0.01):
            antenna.send(device.tick())

    speaker = threading.Thread(target=speak)
    speaker.start()
    heard = check_link(settings_with({"kind": "serial", "port": path}))
    over.set()
    speaker.join()
    assert (
        heard.good
        and heard.frames["drive_status"] > 0
        and heard.frames["drive_status"] == heard.frames["feedback_outer"]
    )
    antenna.close()


def test_a_port_that_is_not_there_is_a_reason_and_not_an_exception(tmp_path: Path) -> None:
    report = check_link(settings_with({"kind": "serial", "port": str(tmp_path / "nothing")}))
    assert not report.good and "no such port" in report.reasons[0]
    report = check_link(settings_with({"kind": "can", "interface": "socketcan", "channel": "nocan0"}))
    assert not report.good and report.bus_load is not None and 0.0 < report.bus_load < 0.6
    assert check_link(shipped_settings()).good
