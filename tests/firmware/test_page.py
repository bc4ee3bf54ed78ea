"""What is handed over with the C device: the settings of an antenna; the page tells its sizes as they are."""

from __future__ import annotations

import ctypes
import re
import shutil
from pathlib import Path

import pytest

from gimbal_hil.surface.cli.app import run
from sim_backend.device import Device
from sim_backend.firmware import SETTINGS_FILE, HostBench, SmallBench, device_files, fill_settings
from sim_backend.model import model_named
from tests.firmware.stack import deepest
from tests.firmware.test_sources import objects
from tests.firmware.test_sources import run as run_tool

PAGE = (Path(__file__).parents[2] / "docs" / "how-to" / "take-the-c-device.md").read_text()


@pytest.mark.parametrize("name", ["thesis", "realistic"])
def test_the_settings_that_are_handed_over_are_those_of_the_antenna(name: str, tmp_path: Path) -> None:
    model = model_named(name)
    assert run("protocol", ["--device", str(tmp_path), "--model", name]) == 0
    assert {file.name for file in tmp_path.iterdir()} == set(device_files(model, 1000.0))
    settings, text = HostBench().settings, (tmp_path / SETTINGS_FILE).read_text()
    fill_settings(settings, Device(model).drive, 2)
    ends = {"INT32_MIN": -(1 << 31), "INT32_MAX": (1 << 31) - 1}
    told = [ends.get(value) or int(value) for value in re.findall(r"= (-?\d+|INT32_M\w+),", text)]
    joints = [getattr(joint, field[0]) for joint in settings.joints for field in joint._fields_]
    own = [getattr(settings, field[0]) for field in settings._fields_ if field[0] != "joints"]
    assert told == own + joints


def test_files_that_differ_are_not_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / SETTINGS_FILE).write_text("mine")
    words = ["--device", str(tmp_path)]
    with pytest.raises(SystemExit) as refused:
        run("protocol", words)
    assert refused.value.code == 2 and SETTINGS_FILE in capsys.readouterr().err
    assert [file.name for file in tmp_path.iterdir()] == [SETTINGS_FILE]
    assert run("protocol", [*words, "--force"]) == 0


@pytest.mark.skipif(shutil.which("arm-none-eabi-gcc") is None, reason="needs arm-none-eabi-gcc")
def test_the_sizes_on_the_page_are_not_exceeded(tmp_path: Path) -> None:
    """Another version of the compiler may need a little more."""
    told = [int(n) for n in re.findall(r"\b(\d+)\b", PAGE.partition("| bytes |")[2].partition("A tick")[0])]
    made = objects(tmp_path, "-Os", "-fstack-usage")
    sizes = [int(row.split()[0]) for row in run_tool("arm-none-eabi-size", *made).splitlines()[1:]]
    members = {name: ctypes.sizeof(kind) for name, kind in SmallBench._fields_}
    stack, _ = deepest(made, "gimbal_device_tick")
    found = [sum(sizes[:-1]), sizes[-1], *(members[name] for name in ("device", "settings", "stream", "packet")), stack]
    assert len(told) == len(found)
    assert all(abs(a - b) <= 0.15 * a for a, b in zip(told, found, strict=True)), (told, found)
