"""The curves that the policy trades along: kept cases of a bench, diagnosed again with one number changed at a time.

    python -m tests.blind.policy FOLDER --numbers sure,exhausted --factors 0.5,2 --cases 'single.*'

needs the logs of the cases (`bench blind --keep all`). The row without a number is the policy as it is. What has been
diagnosed stays in FOLDER/policy.json; a run that was interrupted goes on.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
from collections.abc import Iterable
from concurrent.futures import as_completed
from dataclasses import fields, replace
from fnmatch import fnmatch
from pathlib import Path

from gimbal_hil.knowledge.discrepancy import Policy
from gimbal_hil.knowledge.executor import open_executor
from gimbal_hil.surface.library import question_of
from sim_backend.model import load_model
from tests.blind.figures import case_result
from tests.blind.score import Outcome

#: number of the policy ("" for none) and the factor on it
Change = tuple[str, float]
_AS_IT_IS: Change = ("", 1.0)


def changed(change: Change) -> Policy:
    """The policy with one number multiplied; probabilities stay below one."""
    name, factor = change
    policy = Policy()
    if not name:
        return policy
    value = factor * getattr(policy, name)
    return replace(policy, **{name: min(value, 0.99) if name in ("named", "alone") else value})


def outcomes(folder: Path, changes: Iterable[Change]) -> list[str]:
    """How one kept case ends with each change, by name of `Outcome`."""
    data = folder / "data"
    logs = (sorted(data.glob(f"{use}_*")) for use in ("measured", "holdout"))
    question = question_of(load_model(data / "model.yaml"), *logs)
    truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    found = []
    for change in changes:
        request = replace(question.request, policy=changed(change))
        verdict = replace(question, request=request).asked().verdict.document
        found.append(case_result(folder.name, truth, verdict, {"wall": 0.0, "cpu": 0.0}).outcome.name)
    return found


def rows(ended: dict[str, dict[str, str]], changes: list[Change]) -> list[tuple[str, ...]]:
    """(number, value, cases, right, false, missed or a part, guessed) of every change, over the cases that all have."""
    whole = [case for case in ended.values() if all(_key(change) in case for change in changes)]
    groups = (
        (Outcome.EXACT, Outcome.CLASS, Outcome.ABSTAINED, Outcome.NEAR, Outcome.AKIN),
        (Outcome.FALSE,),
        (Outcome.MISSED, Outcome.PARTLY, Outcome.NO_ANSWER),
        (Outcome.GUESSED,),
    )
    table = []
    for change in changes:
        said = [Outcome[case[_key(change)]] for case in whole]
        value = f"{getattr(changed(change), change[0]):.3g}" if change[0] else "-"
        table.append(
            (change[0] or "as it is", value, str(len(said)), *(str(sum(o in g for o in said)) for g in groups))
        )
    return table


def _key(change: Change) -> str:
    return f"{change[0]}*{change[1]:g}"


def main() -> int:
    """Diagnose, and print the table in Markdown."""
    names = tuple(f.name for f in fields(Policy))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--numbers", default=",".join(names), help="of the policy, comma between")
    parser.add_argument("--factors", default="0.5,2", help="on each of them, comma between")
    parser.add_argument("--cases", default="*", metavar="PATTERN")
    parser.add_argument("--workers", type=int, default=2)
    chosen = parser.parse_args()
    changes = [_AS_IT_IS]
    changes += [(name, float(factor)) for name in chosen.numbers.split(",") for factor in chosen.factors.split(",")]
    store = chosen.folder / "policy.json"
    ended: dict[str, dict[str, str]] = json.loads(store.read_text(encoding="utf-8")) if store.exists() else {}
    kept = [f for f in sorted(chosen.folder.iterdir()) if (f / "data").exists() and fnmatch(f.name, chosen.cases)]
    asked = [(folder, [c for c in changes if _key(c) not in ended.get(folder.name, {})]) for folder in kept]
    asked = [(folder, missing) for folder, missing in asked if missing]
    # one after another where one process does all, so that what is done stays
    ahead = max(1, len(asked)) if chosen.workers > 1 else 1
    with open_executor(chosen.workers) as executor:
        for first in range(0, len(asked), ahead):
            running = {executor.submit(outcomes, *one): one for one in asked[first : first + ahead]}
            for done in as_completed(running):
                folder, missing = running[done]
                ended.setdefault(folder.name, {}).update(zip(map(_key, missing), done.result(), strict=True))
                store.write_text(json.dumps(ended, indent=1), encoding="utf-8")
                print(f"{folder.name}: {ended[folder.name]}", flush=True)
    header = ("number", "value", "cases", "right", "false", "missed or a part", "guessed")
    for row in (header, ("---",) * len(header), *rows(ended, changes)):
        print("| " + " | ".join(row) + " |")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
