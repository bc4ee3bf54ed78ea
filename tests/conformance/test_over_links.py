"""The same requirements on the virtual antenna in another process, over a socket and a pseudo-terminal."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from gimbal_hil.surface.cli.app import run

pytestmark = pytest.mark.realtime
#: short ones of every group
SOME = ("W-03", "W-05", "F-01", "F-03", "I-02", "S-03", "S-07", "D-01", "D-02", "T-02")


@contextmanager
def plant(link: str, ready: Path, *options: str) -> Iterator[str]:
    """The virtual antenna in a process of its own; gives the path to connect to."""
    words = ["plant", "--link", link, "--ready-file", str(ready), "--json", *options]
    program = f"from gimbal_hil.surface.cli.app import main; main({words!r})"
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as served:
        try:
            while not ready.exists():
                assert served.poll() is None, "the plant ended"
                time.sleep(0.05)
            yield ready.read_text().strip()
        finally:
            served.terminate()


@pytest.mark.parametrize("kind", ["unix", "serial"])
def test_an_antenna_in_another_process_meets_the_requirements(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = f"unix:{tmp_path / 'antenna'}" if kind == "unix" else "serial"
    with plant(place, tmp_path / "ready") as path:
        only = [word for number in SOME for word in ("--only", number)]
        code = run("conformance", ["--link", f"{kind}:{path}", *only, "--out", str(tmp_path / "found"), "--json"])
    findings = json.loads(capsys.readouterr().out)["findings"]
    assert {one["id"]: one["text"] for one in findings if one["verdict"] != "passed"} == {}
    assert code == 0 and len(findings) == len(SOME)


@pytest.mark.heavy
@pytest.mark.parametrize("kind", [pytest.param("unix", marks=pytest.mark.heavy), "serial"])
def test_an_antenna_that_waits_in_another_process_meets_every_requirement(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with plant(f"{kind}:{tmp_path / 'antenna'}", tmp_path / "ready", "--lockstep") as path:
        words = ["--link", f"{kind}:{path}", "--lockstep", "--out", str(tmp_path / "found"), "--json"]
        code = run("conformance", words)
    findings = json.loads(capsys.readouterr().out)["findings"]
    assert {one["id"]: one["text"] for one in findings if one["verdict"] != "passed"} == {}
    assert code == 0 and len(findings) == 37


def test_a_link_without_an_antenna_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import os
    import tty

    device, terminal = os.openpty()
    tty.setraw(terminal)
    try:
        with pytest.raises(SystemExit) as refused:
            run("conformance", ["--link", f"serial:{os.ttyname(terminal)}", "--out", str(tmp_path / "found")])
    finally:
        os.close(device)
        os.close(terminal)
    assert refused.value.code == 2 and "no antenna answered" in capsys.readouterr().err
