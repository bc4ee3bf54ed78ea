"""Run the blind bench: draw cases, run the shipped command on the written files, and only then open the truth.

`gimbal-hil bench blind --out DIR` calls this. A case whose result is in the folder is not made again: a bench that was
interrupted goes on, and another version of the code needs a new folder. Cases are spread over processes, one process a
case.
"""

from __future__ import annotations

import os

# every process computes on its own: linear algebra in threads beside them only gets in the way
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import shutil
import sys
from concurrent.futures import as_completed
from dataclasses import asdict, dataclass
from pathlib import Path

from firmware_protocol.errors import BadInputError, GimbalHilError
from gimbal_hil.knowledge.executor import code_fingerprint, open_executor
from tests.blind.answer import VERDICT_FILE, answer_of
from tests.blind.compare import comparison
from tests.blind.figures import CaseResult, results
from tests.blind.files import write_case
from tests.blind.guests import install
from tests.blind.kinds import DECIDE_SEED, Job, Part, all_jobs, jobs, sealed_seed
from tests.blind.page import write_page
from tests.blind.score import GOOD, outcome
from tests.blind.tally import as_json, tables

CHECKOUT = Path(__file__).resolve().parents[2]
BENCH_FILE, TRUTH_FILE, SECONDS_FILE = "bench.json", "truth.json", "seconds.json"


def diagnose_case(job: Job, bench_seed: int, folder: Path, limit_s: int, keep: str) -> float:
    """Draw a case, leave its verdict beside its truth; answers the command's seconds on the wall clock."""
    if not (folder / TRUTH_FILE).exists() or not (folder / "data").exists():
        write_case(job, bench_seed, folder)
    guest = install(job.guest, folder / "guest") if job.guest else None
    verdict, seconds = answer_of(folder / "data", folder / "out", limit_s, guest)
    (folder / SECONDS_FILE).write_text(json.dumps(seconds), encoding="utf-8")
    # a verdict that is there is whole: an interrupted bench must not take half a file for a result
    partial = folder / f"{VERDICT_FILE}.part"
    partial.write_text(json.dumps(verdict, indent=1), encoding="utf-8")
    partial.rename(folder / VERDICT_FILE)
    good = outcome(json.loads((folder / TRUTH_FILE).read_text(encoding="utf-8")), verdict) in GOOD
    if keep == "none" or (keep == "wrong" and good):  # a megabyte a second of log; the seed draws it again
        shutil.rmtree(folder / "data", ignore_errors=True)
        shutil.rmtree(folder / "out", ignore_errors=True)
    return seconds["wall"]


@dataclass(frozen=True)
class Bench:
    """What a result folder is of."""

    seed: int
    sealed: str | None
    code: str

    @staticmethod
    def of(folder: Path) -> Bench | None:
        """The bench that a folder holds, if it holds one."""
        path = folder / BENCH_FILE
        return Bench(**json.loads(path.read_text(encoding="utf-8"))) if path.exists() else None


def _opened(folder: Path, wanted: Bench) -> None:
    """A new folder, or one with results of the same seed; says so when they are another version's."""
    there = Bench.of(folder)
    if there is not None and there.seed != wanted.seed:
        raise BadInputError(str(folder), f"holds cases of seed {there.seed}", f"a new folder for seed {wanted.seed}")
    if there is not None and there.code != wanted.code:
        print("note: verdicts in this folder were made by other code; a new folder makes them anew", flush=True)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / BENCH_FILE).write_text(json.dumps(asdict(wanted)), encoding="utf-8")


def _told(case: CaseResult, took: str) -> None:
    named = (
        ", ".join(f"{name}@{axis}{'' if status == 'named' else '?'}" for name, axis, status in case.named)
        or case.verdict
    )
    hidden = ", ".join(f"{name}@{axis}({size:.2g})" for name, axis, size in case.hidden) or "nothing"
    print(f"{case.outcome.name:9s} {case.name:34s} {hidden} -> {named}  {took}", flush=True)


def _judge(folder: Path, chosen: list[Job], seed: int, workers: int, dask: str | None, limit_s: int, keep: str) -> None:
    for case in results(folder, [job.name for job in chosen]):
        _told(case, "from before")
    pending = [job for job in chosen if not (folder / job.name / VERDICT_FILE).exists()]
    with open_executor(workers, dask) as executor:
        # one after another where one process does all, so that each line is printed when its case is done
        ahead = max(1, len(pending)) if workers > 1 or dask else 1
        for first in range(0, len(pending), ahead):
            now = pending[first : first + ahead]
            running = {executor.submit(diagnose_case, job, seed, folder / job.name, limit_s, keep): job for job in now}
            for done in as_completed(running):
                _told(results(folder, [running[done].name])[0], f"{done.result():.0f} s")


def main() -> int:
    """Draw, diagnose and score; prints a line a case, then the tables, and writes figures.json and report.html."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument(
        "--seed", type=int, help=f"of the whole bench; without it the folder's, or the training set's ({DECIDE_SEED})"
    )
    parser.add_argument("--sealed", metavar="RELEASE", help="the seed that belongs to a tag or commit")
    parser.add_argument("--kinds", help="comma between")
    parser.add_argument("--cases", default="*", metavar="PATTERN", help="names like this, such as 'single.cogging.*'")
    parser.add_argument("--most", type=int, help="at most so many cases of a kind")
    parser.add_argument("--first", type=int, help="so many cases in all")
    parser.add_argument("--workers", type=int, default=2, help="processes, one case in each")
    parser.add_argument("--dask", metavar="ADDRESS", help="diagnose on a Dask cluster instead")
    parser.add_argument(
        "--limit", type=int, default=600, help="processor seconds after which a case counts as without an answer"
    )
    parser.add_argument(
        "--keep", choices=("wrong", "all", "none"), default="wrong", help="whose logs and reports stay on disk"
    )
    parser.add_argument("--table", action="store_true", help="only print the results page of what has been judged")
    parser.add_argument(
        "--compare", type=Path, metavar="OLD", help="only say what differs from the results in another folder"
    )
    chosen = parser.parse_args()
    if chosen.compare is not None:
        print(comparison(chosen.compare, chosen.folder))
        return 0
    there = Bench.of(chosen.folder)
    if chosen.table:
        if there is None:
            raise BadInputError(
                str(chosen.folder), "holds no results of a blind bench", "a folder that `bench blind --out` wrote"
            )
    else:
        seed = sealed_seed(chosen.sealed, CHECKOUT) if chosen.sealed else chosen.seed
        seed = seed if seed is not None else (there.seed if there else DECIDE_SEED)
        kinds = tuple(chosen.kinds.split(",")) if chosen.kinds else ()
        wanted = jobs(seed, Part(kinds, chosen.cases, chosen.most, chosen.first))
        there = Bench(seed, chosen.sealed, code_fingerprint())
        _opened(chosen.folder, there)
        _judge(chosen.folder, wanted, seed, chosen.workers, chosen.dask, chosen.limit, chosen.keep)
    found = results(chosen.folder, [job.name for job in all_jobs()])
    print(("" if chosen.table else "\n") + tables(found, there.seed, there.sealed))
    if chosen.table:
        return 0
    (chosen.folder / "figures.json").write_text(json.dumps(as_json(found, there.seed), indent=1), encoding="utf-8")
    print(f"\n{write_page(found, there.seed, there.sealed, chosen.folder / 'report.html')}")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except GimbalHilError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
