"""Commands of the pages that need a running daemon, given one: each runs as it stands there, in real time."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from tests.command_line.test_commands_of_pages import LINES, ROOT, as_run, exit_code, reason
from tests.daemon.daemons import RunningDaemon

pytestmark = pytest.mark.realtime

#: whose words a daemon answers; what moves comes before what stops, and the end of the daemon last
ORDER = (
    r"^set .*--mode pointing",
    r"^set ",
    r"^daemon --run",
    r"^adjust .*=",
    r"^adjust --back",
    r"^point --target azel|^point --target geo:\S+ --position \S+ --run",
    r"^experiment (plan.yaml|step) --run",
    r"^watch ",
    r"^point --stow",
)
#: of these the pages have names only
NAMES = ("stop", "quick-stop", "reset", "shut-down")
#: a daemon's run, a plan of one's own, and what would take minutes or never end
HERE = {
    r"(?<=--run )(RUN|run|runs/\S+|mine/runs/\S+)(?= |$)": "run",
    r"^watch .*": "watch run --once",
    r"^(set|adjust) .*": r"\g<0> --run run",
    r"--out \S+": "--out made --force",
    r" --model mine/model.yaml": "",
    r"^experiment step.*": r"\g<0> --short --axis outer",
}


def lines() -> list[str]:
    """Those of the pages, in the order in which one daemon can take them, each once."""
    # a share of a learned table needs a configuration that learns one, tests/settings
    found = [
        line
        for pattern in ORDER
        for line in LINES
        if re.search(pattern, line) and reason(line) and "learned" not in line
    ]
    return list(dict.fromkeys(found))


def on_this_daemon(line: str) -> str:
    for pattern, here in HERE.items():
        line = re.sub(pattern, here, line)
    return as_run(line)


def test_every_kind_of_them_is_on_a_page() -> None:
    assert all(any(re.search(pattern, line) for line in lines()) for pattern in ORDER) and len(lines()) >= 12


@pytest.mark.heavy
def test_they_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(ROOT / "config" / "plans" / "two_speeds.yaml", "plan.yaml")
    failed = []
    with RunningDaemon(tmp_path / "run") as daemon, daemon.client() as client:
        daemon.until_state(client, "idle")
        for line in (*map(on_this_daemon, lines()), *(f"{name} --run run" for name in NAMES)):
            code = exit_code(line)
            if code not in (0, None):
                failed.append(f"{line}: {code} {capsys.readouterr().err.strip()[-300:]}")
        assert daemon.wait()[0] == 0
    assert not failed, "\n".join(failed)
