"""Run the blind bench: `python -m tests.blind.run FOLDER [--every N]` draws, diagnoses, and only then opens the truth.

Cases are spread over processes, one process a case. A case whose verdict is in the folder is not made again: a bench that was
interrupted goes on, and a new version needs a new folder. On a Dask cluster the folder must be one that its workers see too.
"""

from __future__ import annotations

import os

# every process computes on its own: linear algebra in threads beside them only gets in the way
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import time
import zlib
from concurrent.futures import as_completed
from pathlib import Path
from typing import Any

from gimbal_hil.discrepancy import diagnose, verdict_of
from gimbal_hil.executor import code_fingerprint, open_executor
from gimbal_hil.signals import read_signals
from sim_backend.model import load_model
from tests.blind.cases import Job, jobs, write_case
from tests.blind.score import outcome
from tests.blind.tally import SECONDS_FILE, tables


def diagnose_folder(data: Path, workers: int = 1) -> dict[str, Any]:
    """The verdict on one case; sees the data folder only."""
    model = load_model(data / "model.yaml")
    measured = tuple(read_signals(path, model.axes) for path in sorted(data.glob("measured_*")))
    holdout = tuple(read_signals(path, model.axes) for path in sorted(data.glob("holdout_*")))
    return verdict_of(diagnose(model, measured, holdout, workers=workers))


def diagnose_case(job: Job, folder: Path) -> float:
    """Draw a case where it is not there yet, leave its verdict beside its data; answers the seconds of the diagnosis."""
    if not (folder / "truth.json").exists():
        write_case(job, folder)
    start = time.perf_counter()
    verdict = diagnose_folder(folder / "data")
    # a verdict that is there is whole: an interrupted bench must not take half a file for a result
    partial = folder / "verdict.json.part"
    partial.write_text(json.dumps(verdict, indent=1), encoding="utf-8")
    partial.rename(folder / "verdict.json")
    seconds = time.perf_counter() - start
    (folder / SECONDS_FILE).write_text(f"{seconds:.1f}", encoding="utf-8")
    return seconds


def main() -> None:
    """Draw, diagnose and score; prints a line a case, then the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--every", type=int, default=1, help="take every n-th case only")
    parser.add_argument("--workers", type=int, default=2, help="processes, one case in each")
    parser.add_argument("--dask", metavar="ADDRESS", help="diagnose on a Dask cluster instead")
    parser.add_argument("--table", action="store_true", help="only print the tables of what has been judged so far")
    chosen = parser.parse_args()
    # in an order that mixes the kinds, so that an interrupted bench has seen some of each
    listed = sorted(jobs()[:: chosen.every], key=lambda job: zlib.crc32(job.name.encode()))
    cases = {job.name: job for job in listed}
    if chosen.table:
        print(tables(chosen.folder, list(cases)))
        return
    finished = {name for name in cases if (chosen.folder / name / "verdict.json").exists()}
    _note_code(chosen.folder, len(finished))

    def judge(name: str, took: str) -> None:
        truth, verdict = (json.loads((chosen.folder / name / file).read_text(encoding="utf-8")) for file in ("truth.json", "verdict.json"))
        judged = outcome(truth, verdict)
        named = ", ".join(f"{e['name']}@{e['axis']}" for e in verdict["effects"]) or verdict["verdict"]
        print(f"{judged.name:9s} {name:40s} {named}  {took}", flush=True)

    for name in cases:
        if name in finished:
            judge(name, "from before")
    with open_executor(chosen.workers, chosen.dask) as executor:
        pending = {executor.submit(diagnose_case, job, chosen.folder / name): name for name, job in cases.items() if name not in finished}
        for done in as_completed(pending):
            judge(pending[done], f"{done.result():.0f} s")
    print("\n" + tables(chosen.folder, list(cases)))


def _note_code(folder: Path, finished: int) -> None:
    """Keep which code a folder's verdicts are from; say so when they are another version's."""
    note = folder / "code.txt"
    if finished and (not note.exists() or note.read_text(encoding="utf-8") != code_fingerprint()):
        print(f"note: {finished} verdicts in this folder were made by other code; a new folder makes them anew", flush=True)
    folder.mkdir(parents=True, exist_ok=True)
    note.write_text(code_fingerprint(), encoding="utf-8")


if __name__ == "__main__":
    main()
