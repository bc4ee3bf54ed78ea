"""What became right and what became wrong between two result folders of one bench."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from firmware_protocol.errors import BadInputError
from tests.blind.figures import CaseResult, results
from tests.blind.kinds import all_jobs
from tests.blind.score import GOOD


def comparison(old: Path, new: Path) -> str:
    """Text on every case that both folders hold and that ended otherwise."""
    seeds = [_seed(folder) for folder in (old, new)]
    if seeds[0] != seeds[1]:
        raise BadInputError(
            "--compare", f"{old} is of seed {seeds[0]}, {new} of seed {seeds[1]}", "two folders of one seed"
        )
    names = [job.name for job in all_jobs()]
    before, after = ({c.name: c for c in results(folder, names)} for folder in (old, new))
    both = sorted(set(before) & set(after))
    right = [n for n in both if before[n].outcome not in GOOD and after[n].outcome in GOOD]
    wrong = [n for n in both if before[n].outcome in GOOD and after[n].outcome not in GOOD]
    other = [n for n in both if before[n].outcome is not after[n].outcome and n not in (*right, *wrong)]
    lines = [f"{len(both)} cases in both folders"]
    for title, chosen in (("became right", right), ("became wrong", wrong), ("otherwise", other)):
        lines.append(f"{title}: {len(chosen)}")
        lines += [
            f"  {n:34s} {before[n].outcome.name} ({_said(before[n])}) -> {after[n].outcome.name} ({_said(after[n])})"
            for n in chosen
        ]
    took = [float(np.median([cases[n].seconds for n in both])) if both else 0.0 for cases in (before, after)]
    lines.append(f"median seconds of a case: {took[0]:.0f} -> {took[1]:.0f}")
    return "\n".join(lines)


def _said(case: CaseResult) -> str:
    return (
        ", ".join(f"{name}@{axis}{'' if status == 'named' else '?'}" for name, axis, status in case.named)
        or case.verdict
    )


def _seed(folder: Path) -> int:
    import json

    path = folder / "bench.json"
    if not path.exists():
        raise BadInputError(str(folder), "holds no results of a blind bench", "a folder that `bench blind --out` wrote")
    return int(json.loads(path.read_text(encoding="utf-8"))["seed"])
