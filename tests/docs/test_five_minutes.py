"""The page "Five minutes": its lines lead from `init` through a live link to the effect that it hides, by name."""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from gimbal_hil.realtime.operator.client import OperatorClient
from tests.daemon.daemons import PATIENCE_S

ROOT = Path(__file__).resolve().parent.parent.parent
PAGE = ROOT / "docs" / "how-to" / "five-minutes.md"
#: what stays in a terminal of its own until it is told to end
STAYING = ("plant", "daemon")
#: a search takes minutes of two cores, and shares them
SEARCH_PATIENCE_S = 900.0

pytestmark = [pytest.mark.realtime]


def lines_of(page: Path, first: int = 1) -> list[str]:
    """Commands of a page from its block `first` on: block 0 mostly installs, which whoever runs a test has done."""
    blocks = re.findall(r"^```sh\n(.*?)^```$", page.read_text(encoding="utf-8"), re.M | re.S)
    return [line for block in blocks[first:] for line in block.splitlines()]


def unnumbered(line: str) -> str:
    """A printed line but for its numbers, which another run has others of."""
    return re.sub(r"\d[\d.]*", "0", line.strip())


def shown_on(page: Path) -> set[str]:
    """What the page says that is printed."""
    blocks = re.findall(r"^```text\n(.*?)^```$", page.read_text(encoding="utf-8"), re.M | re.S)
    return {unnumbered(line) for block in blocks for line in block.splitlines()}


def until_idle(run: Path, daemon: subprocess.Popen[str]) -> None:
    """Wait until the daemon has brought the antenna up."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end and daemon.poll() is None:
        if (run / "operator.json").exists():
            with OperatorClient(run, timeout_s=30.0) as client:
                if client.request("status")["status"]["host_state"] == "idle":
                    return
        time.sleep(0.2)
    raise AssertionError("the gimbal is not ready")


def printed_by(line: str, folder: Path, environment: dict[str, str]) -> str:
    """What a line of the shell prints; on a machine that is too slow for it no process of its own is left."""
    with subprocess.Popen(
        line, shell=True, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        start_new_session=True,
    ) as process:  # fmt: skip
        try:
            out, err = process.communicate(timeout=SEARCH_PATIENCE_S)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            raise
    assert process.returncode == 0, f"{line}\n{out}\n{err}"
    return out


@pytest.mark.realtime
@pytest.mark.heavy
def test_the_lines_of_the_page_name_the_effect_that_it_hides(tmp_path: Path) -> None:
    # the path of a socket has to be short
    drives = Path("/tmp") / f"drives-{os.getpid()}"
    environment = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    staying: list[subprocess.Popen[str]] = []
    told, everything = "", list[str]()
    try:
        for line in lines_of(PAGE):
            line = line.replace("/tmp/drives", str(drives))
            if line.split()[1] in STAYING:
                words = shlex.split(line)
                words[0] = str(Path(sys.executable).with_name(words[0]))
                with (tmp_path / f"{words[1]}.txt").open("w") as out:
                    process = subprocess.Popen(words, cwd=tmp_path, stdout=out, stderr=subprocess.STDOUT, text=True)
                staying.append(process)
                if words[1] == "daemon":
                    until_idle(tmp_path / "mine" / "runs" / "daemon", process)
                continue
            printed = printed_by(line, tmp_path, environment)
            everything += printed.splitlines()
            if " discrepancy " in line:
                told = printed
            if " shut-down " in line:
                assert staying[-1].wait(PATIENCE_S) == 0
    finally:
        for process in staying:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
                process.wait(PATIENCE_S)
    verdict = json.loads((tmp_path / "mine" / "runs" / "verdict" / "verdict.json").read_text())
    assert verdict["verdict"] == "named", verdict["text"]
    (found,) = verdict["effects"]
    assert (found["name"], found["axis"]) == ("cogging", "azimuth")
    assert found["parameters"]["amplitude"]["value"] == pytest.approx(0.1, rel=0.1)
    assert found["parameters"]["order"]["value"] == pytest.approx(14.0, abs=0.1)
    assert told.startswith("named: ")
    everything += [line for name in STAYING for line in (tmp_path / f"{name}.txt").read_text().splitlines()]
    shown = shown_on(PAGE)
    assert shown and not shown - {unnumbered(line) for line in everything}


def test_the_page_is_linked_from_the_first_pages() -> None:
    assert all("five-minutes.md" in (ROOT / page).read_text() for page in ("README.md", "docs/README.md"))
