"""What a command prints as `next:` is run, and what that one prints, and so on: the printed path has no dead end."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from firmware_protocol.documents import read_yaml, yaml_text
from gimbal_hil.data.runs import open_run
from tests.daemon.daemons import RunningDaemon

pytestmark = [pytest.mark.realtime, pytest.mark.heavy]

#: commands that a command proposes where its answer stays open, too
OPEN = (0, 1)


def run(folder: Path, line: str) -> str:
    """Run a printed line; answers the line that it prints as next."""
    program = Path(sys.executable).with_name("gimbal-hil")
    words = shlex.split(line.removeprefix("gimbal-hil "))
    done = subprocess.run([program, *words], cwd=folder, capture_output=True, text=True, check=False, timeout=600)
    assert done.returncode in OPEN, f"{line}: {done.returncode}\n{done.stdout}\n{done.stderr}"
    following = [text for text in done.stdout.splitlines() if text.startswith("next: ")]
    assert following, f"{line} says nothing of what is next\n{done.stdout}"
    return following[-1].removeprefix("next: ")


def chain(folder: Path, first: str, links: int = 3) -> list[str]:
    """A command and the next ones after it, all of them run."""
    lines = [first]
    for _ in range(links):
        lines.append(run(folder, lines[-1]))
    return lines


def names(lines: list[str]) -> list[str]:
    """What each line runs: the command, and of experiments the sequence."""
    words = [shlex.split(line)[1:] for line in lines]
    return [f"{one[0]} {one[1]}" if one[0] == "experiment" else one[0] for one in words]


QUICK = [
    "gimbal-hil effects",
    "gimbal-hil daemon --lockstep --duration 1 --out d",
    "gimbal-hil experiment step --short --out runs/step",
    "gimbal-hil runs list",
    "gimbal-hil init mine --yes --axes azimuth,elevation",
]


@pytest.mark.parametrize("first", QUICK)
def test_a_printed_path_of_three_goes_on(tmp_path: Path, first: str) -> None:
    chain(tmp_path, first)


def test_friction_of_ones_own_gimbal_leads_to_a_search_on_that_gimbal(tmp_path: Path) -> None:
    run(tmp_path, "gimbal-hil init mine --yes --axes azimuth,elevation")
    first = "gimbal-hil experiment sliding --short --config mine/antenna.yaml --out mine/runs/sliding"
    lines = chain(tmp_path, first)
    assert names(lines) == ["experiment sliding", "identify", "experiment survey", "experiment survey_holdout"]
    assert all("--config mine/antenna.yaml" in line for line in lines[2:])


def test_what_was_identified_of_a_virtual_antenna_is_asked_about_that_antenna(tmp_path: Path) -> None:
    first = "gimbal-hil experiment sliding --short --model realistic --out sliding"
    lines = chain(tmp_path, first, links=2)
    lines.append(lines.pop().replace(" survey ", " survey --short "))
    lines += chain(tmp_path, lines[-1], links=3)[1:]
    assert names(lines)[:5] == [
        "experiment sliding", "identify", "experiment survey", "experiment survey_holdout", "discrepancy",
    ]  # fmt: skip
    assert all("--model realistic --known identified/model.yaml" in line for line in lines[2:4])
    assert lines[4].startswith("gimbal-hil discrepancy --model identified/model.yaml --measured survey ")
    # whatever the verdict is, no other antenna is moved for it
    assert "experiment" not in lines[5] or "--model realistic" in lines[5]


def test_a_survey_through_a_daemon_leads_to_a_verdict_and_replays(tmp_path: Path) -> None:
    run(tmp_path, "gimbal-hil init mine --yes --axes azimuth,elevation")
    config = tmp_path / "mine" / "antenna.yaml"
    document = read_yaml(config, "a configuration")
    # a machine that stalls is no antenna that is lost
    document["supervisor"] = dict(document.get("supervisor", {})) | {
        "lost_ticks": 100,
        "deadman": {"window_ticks": 250},
    }
    config.write_text(yaml_text(document))
    with RunningDaemon(tmp_path / "daemon", "--config", str(config)) as daemon:
        with daemon.client() as client:
            daemon.until_state(client, "idle")
        lines = chain(tmp_path, "gimbal-hil experiment survey --short --run daemon --out runs/survey", links=2)
        assert names(lines) == ["experiment survey", "experiment survey_holdout", "discrepancy"]
        assert "--run daemon" in lines[1] and "model.yaml" in lines[2]
        assert "experiment" in run(tmp_path, lines[2])
        with daemon.client() as client:
            client.request("shut_down")
        daemon.wait()
    for name in ("survey", "survey_holdout"):
        assert "export" in run(tmp_path, f"gimbal-hil replay runs/{name}")
        run(tmp_path, f"gimbal-hil export runs/{name} --format csv --out {name}.csv")
        assert open_run(tmp_path / "runs" / name).record.header.axes == ("azimuth", "elevation")
