"""Run a tool on cases and score it.

    python -m tests.benchmarks.naming.run FOLDER --tool bic --first 20
    python -m tests.benchmarks.naming.run FOLDER --command "my-tool {case} {answer}" --called mine
    python -m tests.benchmarks.naming.run FOLDER --table

Cases are drawn into FOLDER once and stay; answers that are there are not asked for again. Without `--sealed COMMIT` the
set is the one that tools may be tuned on.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shlex
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

from tests.benchmarks.naming.cases import DEVELOPMENT, Task, all_tasks, sealed_seed
from tests.benchmarks.naming.folders import write_case
from tests.benchmarks.naming.pictures import drawn
from tests.benchmarks.naming.scoring import Score, score, tally

CHECKOUT = Path(__file__).resolve().parents[3]
RIVALS = ("bic", "plain", "sindy", "narmax", "genetic", "operon", "mujoco_id", "structural", "product")
#: processor seconds that a tool may take for a case
LIMIT_S = 300.0


def answered(command: str, case: Path, answer: Path) -> float:
    """Ask a tool about a case; processor seconds that it took."""
    words = [word.format(case=case, answer=answer) for word in shlex.split(command)]
    # one processor: seconds are to be compared
    alone = {**os.environ, "PYTHONPATH": str(CHECKOUT), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    before = _children_s()
    answer.mkdir(parents=True, exist_ok=True)
    try:
        done = subprocess.run(
            words, env=alone, capture_output=True, text=True, check=False, preexec_fn=_limited, timeout=10 * LIMIT_S
        )
        (answer / "said.txt").write_text(done.stdout[-4000:] + done.stderr[-4000:])
    except subprocess.TimeoutExpired:
        (answer / "said.txt").write_text("no answer in time")
    seconds = _children_s() - before
    (answer / "seconds.json").write_text(json.dumps(seconds))
    return seconds


def _limited() -> None:
    hard = resource.getrlimit(resource.RLIMIT_CPU)[1]
    limit = round(LIMIT_S) if hard == resource.RLIM_INFINITY else min(round(LIMIT_S), hard)
    resource.setrlimit(resource.RLIMIT_CPU, (limit, hard))


def _children_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def scores_of(folder: Path, tool: str, tasks: list[Task]) -> list[Score]:
    """Scores of the answers of a tool that are there."""
    found = []
    for task in tasks:
        answer = folder / "answers" / tool / task.name
        if (answer / "seconds.json").exists():
            seconds = json.loads((answer / "seconds.json").read_text())
            found.append(score(folder / "truth" / f"{task.name}.json", folder / "cases" / task.name, answer, seconds))
    return found


def all_scores(folder: Path, tasks: list[Task]) -> dict[str, list[Score]]:
    """Scores of every tool that has answered, best first."""
    tools = sorted((path.name for path in (folder / "answers").iterdir()), reverse=True)
    found = {tool: scores for tool in tools if (scores := scores_of(folder, tool, tasks))}
    return dict(sorted(found.items(), key=lambda pair: -good(pair[1])))


def good(scores: list[Score]) -> float:
    """Share of cases that are all right."""
    return sum(one.good for one in scores) / len(scores)


def table(folder: Path, tasks: list[Task]) -> str:
    """A line for each tool that has answered, best first."""
    lines = [
        "| tool | cases | all right | exact | right class | false name | false on nothing | silent: something, nothing "
        "| Brier | too sure by | closed on a new trajectory | processor s |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for tool, scores in all_scores(folder, tasks).items():
        t = tally(scores)
        lines.append(
            f"| `{tool}` | {t.cases} | {good(scores):.0%} | {t.exact:.0%} | {t.right_class:.0%} | {t.false:.0%} "
            f"| {t.false_on_nothing:.0%} | {t.silent_on_something:.0%}, {t.silent_on_nothing:.0%} | {t.brier:.2f} "
            f"| {t.overconfidence:+.2f} | {t.closed_median:.2f} | {t.seconds_median:.1f} |"
        )
    return "\n".join(lines)


def main() -> None:
    """The command line."""
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("folder", type=Path)
    reader.add_argument("--tool", choices=RIVALS, action="append", default=[], help="an adapter of this package")
    reader.add_argument("--python", default=sys.executable, help="interpreter of the adapters, with their packages")
    reader.add_argument("--knob", help="in place of the adapter's own")
    reader.add_argument("--command", help="any other tool: {case} and {answer} are the two folders")
    reader.add_argument("--called", default="mine", help="its name in the table")
    reader.add_argument("--first", type=int, default=200, help="so many cases, of every kind in its share")
    reader.add_argument("--skip", type=int, default=0, help="but not the first so many")
    reader.add_argument("--sealed", metavar="COMMIT", help="cases of the seed that belongs to a commit")
    reader.add_argument("--table", action="store_true", help="scores of what has been answered")
    reader.add_argument("--picture", type=Path, help="draw what probabilities were worth (SVG)")
    reader.add_argument("--cases", action="store_true", help="a line for each case")
    chosen = reader.parse_args()
    seed = sealed_seed(chosen.sealed, CHECKOUT) if chosen.sealed else DEVELOPMENT
    tasks = all_tasks()[chosen.skip : chosen.first]
    knob = f" --knob {chosen.knob}" if chosen.knob else ""
    called = f"-{chosen.knob}" if chosen.knob else ""
    asked = {
        f"{tool}{called}": f"{chosen.python} -m tests.benchmarks.naming.rivals.{tool} {{case}} {{answer}}{knob}"
        for tool in chosen.tool
    }
    if chosen.command:
        asked[chosen.called] = chosen.command
    for task in tasks:
        case, truth = chosen.folder / "cases" / task.name, chosen.folder / "truth" / f"{task.name}.json"
        if not truth.exists():
            write_case(task, seed, case, truth)
        for tool, command in asked.items():
            answer = chosen.folder / "answers" / tool / task.name
            if not (answer / "seconds.json").exists():
                seconds = answered(command, case, answer)
                one = score(truth, case, answer, seconds)
                print(f"{task.name:36s} {tool:10s} {'right' if one.good else 'wrong':6s} {seconds:6.1f} s", flush=True)
    if chosen.cases:
        for tool in asked:
            for one in scores_of(chosen.folder, tool, tasks):
                print(json.dumps({"tool": tool, **asdict(one)}))
    if chosen.table:
        print(table(chosen.folder, tasks))
    if chosen.picture is not None:
        chosen.picture.write_text(drawn(all_scores(chosen.folder, tasks)), encoding="utf-8")


if __name__ == "__main__":
    main()
