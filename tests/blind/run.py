"""Run the blind bench: `python -m tests.blind.run FOLDER [--every N]` draws, diagnoses, and only then opens the truth."""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from gimbal_hil.discrepancy import diagnose, verdict_of
from gimbal_hil.signals import read_signals
from sim_backend.model import load_model
from tests.blind.cases import jobs, write_case
from tests.blind.score import Outcome, outcome, parameter_errors


def diagnose_folder(data: Path, workers: int = 2) -> dict[str, Any]:
    """The verdict on one case; sees the data folder only."""
    model = load_model(data / "model.yaml")
    measured = tuple(read_signals(path, model.axes) for path in sorted(data.glob("measured_*")))
    holdout = tuple(read_signals(path, model.axes) for path in sorted(data.glob("holdout_*")))
    return verdict_of(diagnose(model, measured, holdout, workers=workers))


def main() -> None:
    """Draw, diagnose and score; prints a line a case and a table of outcomes by kind of case."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--every", type=int, default=1, help="take every n-th case only")
    parser.add_argument("--workers", type=int, default=2)
    chosen = parser.parse_args()
    table: dict[str, Counter[str]] = {}
    errors: list[tuple[str, float, bool]] = []
    for job in jobs()[:: chosen.every]:
        folder = chosen.folder / job.name
        if not (folder / "truth.json").exists():
            write_case(job, folder)
        start = time.perf_counter()
        verdict = diagnose_folder(folder / "data", chosen.workers)
        (folder / "verdict.json").write_text(json.dumps(verdict, indent=1), encoding="utf-8")
        truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
        judged = outcome(truth, verdict)
        table.setdefault(job.name.split(".")[0], Counter())[judged.value] += 1
        errors += parameter_errors(truth, verdict)
        named = ", ".join(f"{e['name']}@{e['axis']}" for e in verdict["effects"]) or verdict["verdict"]
        print(f"{judged.name:9s} {job.name:40s} {named}  {time.perf_counter() - start:.0f} s", flush=True)
    print("\n| kind | " + " | ".join(o.value for o in Outcome) + " |\n|---|" + "---|" * len(Outcome))
    for kind, counts in sorted(table.items()):
        print(f"| {kind} | " + " | ".join(str(counts[o.value]) for o in Outcome) + " |")
    if errors:
        sizes = np.array([error for _, error, _ in errors])
        covered = np.mean([c for _, _, c in errors])
        print(f"\nparameters within 10 %: {np.mean(sizes < 0.1):.0%}; intervals that cover the truth: {covered:.0%}")


if __name__ == "__main__":
    main()
