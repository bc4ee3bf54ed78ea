"""A daemon whose terminal is closed (ssh) stops as by any signal, and its run says so."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
import time
from pathlib import Path

import pytest

from firmware_protocol.errors import EXIT_INTERRUPTED
from gimbal_hil.data.runs import damage_of, open_run
from tests.daemon.daemons import PATIENCE_S, patient_configuration

pytestmark = pytest.mark.realtime


def test_a_lost_terminal_ends_the_daemon_with_its_run_sealed_and_the_reason_in_it(tmp_path: Path) -> None:
    run, configuration = tmp_path / "run", patient_configuration(tmp_path)
    words = ["-c", "from gimbal_hil.surface.cli import main; main()", "daemon"]
    keyboard, screen = pty.openpty()
    daemon = subprocess.Popen(
        ["setsid", "--ctty", sys.executable, *words, "--config", str(configuration), "--out", str(run)],
        stdin=screen,
        stdout=screen,
        stderr=screen,
    )
    os.close(screen)
    try:
        end = time.monotonic() + PATIENCE_S
        while not ((run / "ticks.arrow").exists() and (run / "ticks.arrow").stat().st_size > 100_000):
            assert daemon.poll() is None and time.monotonic() < end
            time.sleep(0.05)
        os.close(keyboard)
        assert daemon.wait(PATIENCE_S) == EXIT_INTERRUPTED
    finally:
        daemon.kill()
        daemon.wait()
    recorded = open_run(run)
    assert recorded.record.end is not None and recorded.record.end.reason == "SIGHUP"
    assert not list(damage_of(recorded))
