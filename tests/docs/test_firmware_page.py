"""The how-to for firmware keeps to the source: its C compiles, its figures and transitions are those of the code."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from firmware_protocol.emit import committed_path
from firmware_protocol.enumerations import DriveRequest, DriveState
from firmware_protocol.schema import BY_NAME, name_code
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.surface.cli.app import run
from sim_backend.device.drive import destination
from sim_backend.device.settings import FirmwareSettings

PAGE = Path(__file__).resolve().parents[2] / "docs" / "how-to" / "write-your-firmware.md"
TEXT = PAGE.read_text() if PAGE.exists() else ""
pytestmark = pytest.mark.skipif(not TEXT, reason="needs the source checkout")
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror", "-fsyntax-only")
#: states in which a request is heard at all
HEARD = [state for state in DriveState if state.name not in ("NOT_READY", "FAULT_REACTION_ACTIVE", "FAULT")]


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler here")
def test_the_tick_on_the_page_compiles_against_the_header(tmp_path: Path) -> None:
    source = tmp_path / "tick.c"
    source.write_text("\n".join(re.findall(r"^```c\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)))
    done = subprocess.run(
        ["cc", *STRICT, f"-I{committed_path('c').parent}", str(source)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-3000:]


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler here")
def test_the_main_loop_around_the_c_device_compiles(tmp_path: Path) -> None:
    source, page = tmp_path / "main.c", PAGE.with_name("take-the-c-device.md").read_text()
    source.write_text("\n".join(re.findall(r"^```c\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)))
    assert run("protocol", ["--device", str(tmp_path / "gimbal"), "--model", "thesis"]) == 0
    words = ["cc", "-std=c11", *STRICT[1:], f"-I{tmp_path / 'gimbal'}"]
    sources = [str(file) for file in (source, *(tmp_path / "gimbal").glob("*.c"))]
    done = subprocess.run([*words, *sources], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]


def test_the_figures_on_the_page_are_those_of_the_code() -> None:
    supervisor = shipped_settings().supervisor
    for key in ("lost_ticks", "set_point_lag_ticks", "debounce_ticks"):
        assert set(re.findall(rf"`{key}`\s+\((\d+)\)", TEXT)) == {str(getattr(supervisor, key))}, key
    assert f"`synchronise_time_s` ({supervisor.synchronise_time_s:g} s)" in TEXT
    assert f"after {supervisor.connect_ticks} whole feedback sets" in TEXT
    assert f"every {BY_NAME['motor_status_outer'].period_ticks} ticks" in TEXT
    assert f"0x{name_code('thesis'):08X}" in TEXT
    assert f"{FirmwareSettings.control_silence_ticks} ticks without `drive_control`" in TEXT


@pytest.mark.parametrize("request_", list(DriveRequest))
@pytest.mark.parametrize("state", HEARD)
def test_the_table_of_transitions_is_that_of_the_drive(state: DriveState, request_: DriveRequest) -> None:
    rows = re.findall(r"^\| ([^|]+) \| ([^|]+) \| ([A-Z_]+)[^|]*\|$", TEXT, re.MULTILINE)
    wanted = {
        to
        for from_, on, to in rows
        if re.search(rf"\b{request_.name}\b", on)
        and (
            from_ == state.name
            or from_ == "any"
            or (from_ == "any but QUICK_STOP_ACTIVE" and state is not DriveState.QUICK_STOP_ACTIVE)
            or (
                from_ == "any other but QUICK_STOP_ACTIVE"
                and state not in (DriveState.QUICK_STOP_ACTIVE, DriveState.OPERATION_ENABLED)
            )
        )
    }
    reached = DriveState(destination(int(state), int(request_), True))
    assert (wanted or {state.name}) == {reached.name}
