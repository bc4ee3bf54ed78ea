"""Files for a machine that runs the daemon for good are accepted by the programs that read them."""

from __future__ import annotations

import json
import shutil
import socket
import subprocess
from http.client import HTTPConnection
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from gimbal_hil.loop.settings import shipped_settings_path
from gimbal_hil.realtime.dashboard import PageServer
from gimbal_hil.realtime.service.notice import Notice
from gimbal_hil.realtime.telemetry import LiveView
from gimbal_hil.surface.cli import app
from gimbal_hil.surface.cli.commands import COMMANDS
from gimbal_hil.surface.deployment import UnitChoice, grafana_dashboard, manual_page, unit_text
from gimbal_hil.surface.deployment.grafana import queried_metrics

pytestmark = pytest.mark.realtime


def service(*words: str | Path) -> int:
    return app.run("service", [str(word) for word in words])


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd-analyze is not there")
@pytest.mark.parametrize("named", ["antenna.yaml", 'it\'s 100 % $HOME; `x` "two" & \\ more'])
@pytest.mark.parametrize("runs", [None, Path("/var/lib/gimbal-hil")])
def test_systemd_accepts_the_unit_and_finds_nothing_unknown_in_it(
    named: str, runs: Path | None, tmp_path: Path
) -> None:
    program = tmp_path / "gimbal-hil"
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    config = tmp_path / named
    choice = UnitChoice(program, config, runs or tmp_path / named, "root", 8765, 10)
    unit = tmp_path / "gimbal-hil.service"
    unit.write_text(unit_text(choice))
    done = subprocess.run(
        ["systemd-analyze", "verify", "--man=no", str(unit)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0 and "gimbal-hil.service" not in done.stderr, done.stderr


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd-analyze is not there")
def test_systemd_finds_the_unit_little_exposed(tmp_path: Path) -> None:
    unit = tmp_path / "gimbal-hil.service"
    unit.write_text(unit_text(UnitChoice(Path("/bin/sh"), tmp_path / "a.yaml", tmp_path / "runs", "gimbal", 8765)))
    words = ["systemd-analyze", "security", "--offline=true", "--no-pager", "--threshold=45", str(unit)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    # of 100 at most: what is left is the network, devices, memory that is compiled into, and real-time priority
    assert done.returncode == 0 and "OK" in done.stdout, done.stdout + done.stderr


def test_the_manual_that_a_unit_names_is_written_with_it(tmp_path: Path) -> None:
    words = ("install", "--config", shipped_settings_path(), "--runs", tmp_path / "runs")
    assert service(*words, "--out", tmp_path / "50 % units") == 0
    page = tmp_path / "50 % units" / "gimbal-hil.1"
    assert page.read_text().startswith(".TH")
    named = (page.parent / "gimbal-hil.service").read_text().split("Documentation=")[1].splitlines()[0]
    assert named.replace("%%", "%") == page.as_uri()


def test_a_unit_is_installed_for_a_configuration_that_is_good_and_nothing_is_replaced(tmp_path: Path) -> None:
    words = ("install", "--config", shipped_settings_path(), "--out", tmp_path / "units", "--runs", tmp_path / "runs")
    assert service(*words) == 0
    text = (tmp_path / "units" / "gimbal-hil.service").read_text()
    assert "Type=notify" in text and "WatchdogSec=10" in text and f'ReadWritePaths="-{tmp_path / "runs"}"' in text
    assert "LimitRTPRIO=95" in text and "RestartPreventExitStatus=2 3" in text
    for again in (words, ("install", "--out", tmp_path / "b"), (*words[:-1], tmp_path / "a\nb", "--force")):
        with pytest.raises(SystemExit) as end:
            service(*again)
        assert end.value.code == 2
    assert not (tmp_path / "b").exists()


def test_a_unit_makes_its_folder_waits_for_its_device_and_keeps_the_socket_where_operators_see_it() -> None:
    text = unit_text(UnitChoice(Path("/opt/gimbal-hil"), Path("/etc/a $b.yaml"), Path("/var/lib/gimbal/a"), "g"))
    assert 'StateDirectory="gimbal/a"' in text and "ExecStartPre=+" not in text
    assert 'ExecStart="/opt/gimbal-hil" daemon --wait --config "/etc/a $$b.yaml"\n' in text
    # PrivateTmp hides what lies in /tmp, and the door goes where this says
    assert "PrivateTmp=yes" in text and "RuntimeDirectory=gimbal-hil\n" in text
    assert "Environment=XDG_RUNTIME_DIR=%t/gimbal-hil\n" in text and "/bin/sh" not in text
    elsewhere = unit_text(UnitChoice(Path("/opt/gimbal-hil"), Path("/etc/a.yaml"), Path("/data/a b"), "g"))
    assert 'ExecStartPre=+/usr/bin/install -d -m 0750 -o g "/data/a b"' in elsewhere
    assert "WorkingDirectory=-/data/a b\n" in elsewhere and "StateDirectory" not in elsewhere


def test_a_unit_that_was_stopped_has_not_failed_and_is_not_started_again_after_a_safety_stop() -> None:
    lines = unit_text(UnitChoice(Path("/opt/gimbal-hil"), Path("/etc/a.yaml"), Path("/data"), "g")).splitlines()
    # a daemon that a signal ends answers 130
    assert "SuccessExitStatus=130" in lines and "KillSignal=SIGTERM" in lines
    assert "Restart=on-failure" in lines and "RestartPreventExitStatus=2 3" in lines


def test_systemd_hears_once_that_ticks_run_and_then_at_a_third_of_its_watchdog(tmp_path: Path) -> None:
    heard = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    heard.bind(str(tmp_path / "notify"))
    heard.setblocking(False)
    now_s = [0.0]
    environment = {"NOTIFY_SOCKET": str(tmp_path / "notify"), "WATCHDOG_USEC": "9000000"}
    notice = Notice(environment, lambda: now_s[0])
    with heard:
        for now_s[0] in (0.0, 1.0, 2.9, 3.0, 5.0, 6.1):
            notice.ticks_came()
        found = []
        for _ in range(4):
            found.append(heard.recv(100).decode())
        with pytest.raises(BlockingIOError):
            heard.recv(100)
    assert found == ["READY=1\nSTATUS=ticks run", "WATCHDOG=1", "WATCHDOG=1", "WATCHDOG=1"]
    Notice({}, lambda: 0.0).ticks_came()
    Notice({"NOTIFY_SOCKET": str(tmp_path / "nobody")}, lambda: 0.0).ticks_came()


def test_every_metric_that_the_dashboard_asks_for_is_told(tmp_path: Path) -> None:
    pytest.importorskip("prometheus_client", reason="the extra metrics is not installed")
    from gimbal_hil.realtime.dashboard.metrics import metrics_text

    assert service("grafana", "--out", tmp_path) == 0
    document = json.loads((tmp_path / "gimbal-hil-grafana.json").read_text())
    assert document == json.loads(grafana_dashboard()) and len(document["panels"]) == 14
    text = (metrics_text(LiveView(1_000_000, ("outer", "inner"))) or b"").decode()
    # a position is told once one is known
    told = {line.split()[2] for line in text.splitlines() if line.startswith("# TYPE")} | {
        line.split("{")[0].split()[0] for line in text.splitlines() if not line.startswith("#")
    }
    assert queried_metrics() <= told | {f"{name}_total" for name in told}


def test_a_container_file_compiles_at_build_time_and_runs_the_daemon(tmp_path: Path) -> None:
    assert service("container", "--out", tmp_path) == 0
    text = (tmp_path / "Containerfile").read_text()
    assert text.index("pip install") < text.index("RUN gimbal-hil warm") < text.index('ENTRYPOINT ["gimbal-hil"]')
    assert "/src/config/virtual_antenna.yaml" in text


def test_a_container_file_takes_a_configuration_from_within_the_build_folder_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    build, config = tmp_path / "build", tmp_path / "build" / "mine" / "antenna.yaml"
    config.parent.mkdir(parents=True)
    config.write_text(shipped_settings_path().read_text())
    monkeypatch.chdir(build)
    for number, given in enumerate((config, Path("mine/antenna.yaml"))):
        assert service("container", "--config", given, "--out", tmp_path / str(number)) == 0
        written = "".join(path.read_text() for path in (tmp_path / str(number)).iterdir())
        assert "/src/mine/antenna.yaml" in written and "/src//" not in written
    with pytest.raises(SystemExit) as end:
        service("container", "--config", shipped_settings_path(), "--out", tmp_path / "no")
    assert end.value.code == 2
    assert "not copied" in capsys.readouterr().err


def test_every_command_has_a_man_page_made_of_its_help(tmp_path: Path) -> None:
    assert service("man", "--out", tmp_path) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"gimbal-hil.1"} | {
        f"gimbal-hil-{name}.1" for name in COMMANDS
    }
    page = (tmp_path / "gimbal-hil-discrepancy.1").read_text()
    assert page.startswith('.TH "GIMBAL-HIL-DISCREPANCY" 1 ') and "\\-\\-holdout" in page and "survey_holdout" in page
    assert ".SH NAME\ngimbal\\-hil\\-discrepancy \\- " in page
    # what would be a request is text
    assert "\n\\&.hidden" in manual_page("x", "y.", ".hidden", "1", "2026-01-01")


def test_the_live_page_s_server_answers_head_as_get_without_the_content() -> None:
    server = PageServer(LiveView(1_000_000, ("outer", "inner")), 0)
    try:
        found = []
        for method in ("GET", "HEAD"):
            connection = HTTPConnection(urlsplit(server.url).netloc, timeout=10)
            connection.request(method, "/metrics")
            answer = connection.getresponse()
            found.append((answer.status, answer.headers["Content-Type"], len(answer.read())))
            connection.close()
    finally:
        server.close()
    (status, kind, size), head = found
    assert status in (200, 501) and size > 0 and head == (status, kind, 0)
