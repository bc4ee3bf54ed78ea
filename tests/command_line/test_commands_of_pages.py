"""Every command on every page is one that the program understands; those in blocks that need no hardware run."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import typer.main

from gimbal_hil.surface.cli.app import _repeated, run
from gimbal_hil.surface.cli.commands import COMMANDS, function_of
from gimbal_hil.surface.cli.completion import whole_app

ROOT = Path(__file__).resolve().parent.parent.parent
#: records tell of their day, the changelog of what was
PAGES = sorted(
    [ROOT / "README.md", *(path for path in (ROOT / "docs").rglob("*.md") if path.parent.name != "decisions")]
)
#: what a page writes for a number of the reader's
_NUMBERS = {"N": "3", "S": "60", "HZ": "500", "PORT": "0"}
_FENCED = re.compile(r"```(?:sh|yaml)\n(.*?)```", re.S)
_IN_A_LINE = re.compile(r"`(gimbal-hil [^`]+)`")


def commands_in(text: str) -> Iterator[str]:
    """Command lines of blocks (fenced or indented) and of code within sentences, without comments."""
    lines = [line for block in _FENCED.findall(text) for line in _in_one_line(block).splitlines()]
    outside = re.sub(r"```.*?```", "", text, flags=re.S)
    lines += re.findall(r"^    (gimbal-hil .*)$", _in_one_line(outside), re.M)
    lines += [" ".join(found.split()) for found in _IN_A_LINE.findall(outside)]
    for line in lines:
        for part in re.split(r"&&|;", re.sub(r"\s+#.*", "", line)):
            _, found, rest = part.partition("gimbal-hil ")
            if found and (rest.split() or [""])[0] in COMMANDS and " pip " not in part:
                yield f"gimbal-hil {rest.strip()}"


def _in_one_line(text: str) -> str:
    """Commands that go on in the next line, after a backslash or with an option, in one."""
    return re.sub(r"\n +(?=--)", " ", text.replace("\\\n", " "))


def words_of(line: str) -> list[str]:
    """The words of a command line; of what is optional on a page everything, of alternatives the first."""
    line = re.sub(r"\|[^\]|]*(?=[\]|])", "", line).replace("[", " ").replace("]", " ").replace("...", " ")
    return [_NUMBERS.get(word, word) for word in shlex.split(line)[1:]]


UNDERSTOOD = sorted({(page.name, line) for page in PAGES for line in commands_in(page.read_text(encoding="utf-8"))})


@cache
def the_program() -> Any:
    """All commands, with their options."""
    return typer.main.get_command(whole_app())


@pytest.mark.parametrize(("page", "line"), UNDERSTOOD, ids=[f"{page}-{line}"[:90] for page, line in UNDERSTOOD])
def test_a_command_on_a_page_is_one_that_the_program_understands(page: str, line: str) -> None:
    name, *words = words_of(line)
    command = the_program().commands[name]
    if not words or words[-1] in ("--emit", "--link"):
        return  # the name of a command or of an option, in a sentence
    command.make_context(name, _repeated(words, getattr(function_of(name)[0], "MANY_VALUED", ())))


def test_every_page_with_commands_was_found() -> None:
    assert len(UNDERSTOOD) > 100 and {"pointing.md", "arena.md", "README.md"} <= {page for page, _ in UNDERSTOOD}


#: what stands on a page for a file, a folder or a name of the reader's, and what is taken here
OF_THE_READER = {
    "--out RUN": "--out made",
    "CONFIG": "antenna/antenna.yaml",
    "FILE.csv": "file.csv",
    "FILE": "antenna/antenna.yaml",
    "RUN": "runs/step",
    "PLAN": "plan.yaml",
    "MODEL": "antenna/model.yaml",
    "DIR": "made",
    "/etc/gimbal-hil/antenna.yaml": "antenna/antenna.yaml",
    "antenna_model.yaml": "antenna/model.yaml",
    "effects NAME": "effects cogging",
}
#: logs that fit the model beside them, with others a search takes minutes; and antennas in folders of their own
LOGS = {
    r"(?<=--measured )\S+?(?=\]| )": "runs/survey",
    r"(?<=--holdout )\S+?(?=\]| )": "runs/holdout",
    r"(?<=^discrepancy --model )mine/model.yaml": "antenna/model.yaml",
    r"(?<=^identify )RUN( RUN)?": "runs/sliding",
    r"(?<=^init )mine(?= --yes --kind| --link)": "other",
}
#: what would take minutes, made short: pattern of a line, what is put behind it
SHORTER = {
    r"^experiment (survey|survey_holdout|base_motion)\b": " --short --force",
    r"^experiment plan": " --force",
    r"^point\b": " --duration 5",
    r"^(export|protocol .*--out)": " --force",
    r"^daemon --lockstep": " --duration 2 --force",
    r"^experiment (sliding|presliding)": " --short --axis outer --every 50 --force",
    r"^(discrepancy|identify)": " --force",
    r"^init": " --yes --force",
    r"^doctor": " --seconds 1",
    r"^campaign": " --antennas 5",
    r"^service": " --out made --force",
    r"^protocol --device": " --force",
}
#: what cannot run in a test, and why
NOT_HERE = {
    r"conformance --link (unix|serial)": "hardware",
    r"link (qemu|cortex-m|c)\b": "an emulator or a C compiler, tests/firmware",
    r"realtime|soak": "minutes to hours of real time, tests/bench",
    r"^plant|^daemon(?!.*--lockstep --duration)|--run\b|^watch runs": "two processes in real time, tests/daemon",
    r"^bench": "minutes, tests of each bench",
    r"^(improve|tune|warm|demo)": "minutes, tests of each command",
    r"^changed": "minutes, tests/change",
    r"^joint\b|elbow": "the log of an arm and its URDF, tests/arms",
    r"^experiment thesis": "minutes, tests/thesis",
    r"--column": "the reader's own CSV, tests/signals",
    r"\bNAME\b(?<!effects NAME)|--learned|RUN/scope|--emit$|\[--measured": "a form, or the reader's file",
    r"tle:": "needs skyfield, tests/pointing",
    r"--moving|--duration 600": "an hour of flight, tests/pointing",
    r"^(adjust|set|stop|quick-stop|shut-down|reset|watch)\b": "a running daemon, test_commands_with_a_daemon.py",
    r"^drive-tables\b": "drives of another make, tests/drive_tables",
    r"--measured \S+ --measured|settle\.yaml": "a motion that a verdict of its own made, tests/improvement",
    r"--over-temperature": "logs of several temperatures, tests/identification",
    r"--certify": "minutes of flights, tests/pointing",
    r"^service install$": "the name of a command, tests/deployment",
    r"^check a\.\S+ b\.": "recordings that the page has, in its order, tests/docs/test_raw_files.py",
    r"--fail-on|^experiment step .*--out runs/golden": "the page in its order, tests/docs/test_run_in_ci.py",
    r"^foxglove\b": "a running daemon, tests/foxglove",
    r"^mavlink\b": "two processes in real time, tests/mavlink",
}
#: where no is an answer as good as yes: what this machine can do
EITHER = r"^doctor"
#: made before the commands of any page
BEFORE = (
    "init mine --yes",
    "init antenna --yes --axes outer,inner",
    "init . --yes --axes outer,inner",
    "experiment step --short --axis outer --out runs/step",
    "daemon --lockstep --duration 2 --out runs/golden",
    "daemon --lockstep --duration 2 --out runs/first",
    "experiment survey --short --config antenna/antenna.yaml --out A",
    "experiment survey --short --config antenna/antenna.yaml --out runs/survey",
    "experiment survey_holdout --short --config antenna/antenna.yaml --out runs/holdout",
    "experiment survey_holdout --short --config antenna/antenna.yaml --out B",
    "experiment sliding --short --axis outer --every 50 --config antenna/antenna.yaml --out runs/sliding",
)


def exit_code(line: str) -> object:
    """What a command line answers, in this process and the folder it is in."""
    name, *words = words_of(f"x {line}")
    try:
        return run(name, words)
    except SystemExit as end:
        return end.code


def reason(line: str) -> str | None:
    return next((why for pattern, why in NOT_HERE.items() if re.search(pattern, line)), None)


def as_run(line: str) -> str:
    """A line of a page with files that there are, and short."""
    for pattern, here in LOGS.items():
        line = re.sub(pattern, here, line)
    for word, here in OF_THE_READER.items():
        line = re.sub(rf"(?<![\w/.-]){re.escape(word)}(?![\w/-])", here, line)
    return line + "".join(more for pattern, more in SHORTER.items() if re.search(pattern, line))


#: every line of a page, those within sentences too, where they are more than the name of a command
LINES = dict.fromkeys(line.removeprefix("gimbal-hil ") for _, line in UNDERSTOOD if len(line.split()) > 2)


def test_no_fewer_lines_of_the_pages_are_run() -> None:
    assert len([line for line in LINES if reason(line) is None]) >= 65


@pytest.mark.heavy
def test_commands_of_the_pages_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One after the other in one folder, where antennas of one's own and some runs are."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "config").symlink_to(ROOT / "config")
    failed = []
    for line in (*BEFORE, *(as_run(line) for line in LINES if reason(line) is None)):
        code = exit_code(line)
        if code not in (0, None) and not (code == 1 and re.search(EITHER, line)):
            failed.append(f"{line}: {code} {capsys.readouterr().err.strip()[-300:]}")
    assert not failed, "\n".join(failed)
