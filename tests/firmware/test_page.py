"""The page on the C device tells the settings of the thesis antenna and the sizes as they are."""

from __future__ import annotations

import ctypes
import re
import shutil
from pathlib import Path

import pytest

from sim_backend.device import Device
from sim_backend.firmware import HostBench, SmallBench, fill_settings
from sim_backend.model import shipped_model
from tests.firmware.stack import deepest
from tests.firmware.test_sources import objects, run

PAGE = (Path(__file__).parents[2] / "docs" / "how-to" / "take-the-c-device.md").read_text()


def test_the_settings_on_the_page_are_those_of_the_thesis_antenna() -> None:
    settings = HostBench().settings
    fill_settings(settings, Device(shipped_model()).drive, 2)
    told = re.search(r"settings = \{(.*?)^\};", PAGE, re.MULTILINE | re.DOTALL)
    assert told is not None
    drive, joints = told.group(1).split(".joints =")
    for name, value in re.findall(r"\.(\w+) = (0x[0-9A-F]+|\d+)", drive):
        assert getattr(settings, name) == int(value, 0), name
    for axis, text in enumerate(joints.split("},")):
        for name, value in re.findall(r"\.(\w+) = (-?\d+)", text):
            assert getattr(settings.joints[axis], name) == int(value), (axis, name)


@pytest.mark.skipif(shutil.which("arm-none-eabi-gcc") is None, reason="needs arm-none-eabi-gcc")
def test_the_sizes_on_the_page_are_not_exceeded(tmp_path: Path) -> None:
    """Another version of the compiler may need a little more."""
    told = [int(n) for n in re.findall(r"\b(\d+)\b", PAGE.partition("| bytes |")[2].partition("A tick")[0])]
    made = objects(tmp_path, "-Os", "-fstack-usage")
    sizes = [int(row.split()[0]) for row in run("arm-none-eabi-size", *made).splitlines()[1:]]
    members = {name: ctypes.sizeof(kind) for name, kind in SmallBench._fields_}
    stack, _ = deepest(made, "gimbal_device_tick")
    found = [sum(sizes[:-1]), sizes[-1], *(members[name] for name in ("device", "settings", "stream", "packet")), stack]
    assert len(told) == len(found)
    assert all(abs(a - b) <= 0.15 * a for a, b in zip(told, found, strict=True)), (told, found)
