"""Which cases there are: 200, of every kind that the generator has, in an order that is fixed.

The development set is of a seed that everybody knows, with its truth. A test set is of the seed that belongs to a
commit, which nobody knew before that commit was made.
"""

from __future__ import annotations

import hashlib
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tests.blind.causes import catalogue, outside
from tests.blind.draw import Case, Unstable, Wrong, draw

DEVELOPMENT = 0
#: seconds of each log: of the whole two-axis motion, reversals and sweeps included
SECONDS = 30.0


@dataclass(frozen=True)
class Task:
    """A case by name, its kind first, and what is hidden in it."""

    name: str
    arguments: dict[str, Any] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """The first word of the name."""
        return self.name.split(".")[0]

    def drawn(self, seed: int) -> Case:
        """The case of a set; of a loop that does not stand what is hidden the next draw."""
        first = _digest(seed, self.name) % 2**62
        for again in range(10):
            try:
                return draw(first + again, duration_s=SECONDS, **self.arguments)
            except Unstable:
                continue
        raise Unstable(f"{self.name}: ten draws in a row")


def _digest(*words: object) -> int:
    return int.from_bytes(hashlib.sha256("/".join(map(str, words)).encode()).digest()[:16], "big")


def all_tasks() -> list[Task]:
    """The 200 cases; the first N of them have every kind in about its share."""
    dice = np.random.default_rng(0)
    names = [cause.name for cause in catalogue(dice, "outer", 0)]
    strange = [cause.name for cause in outside(dice, "outer")]
    found = [
        Task(f"single.{name}.{axis}.{k}", {"names": [name], "axis": axis})
        for k in range(2) for name in names for axis in ("outer", "inner")
    ]  # fmt: skip
    found += [
        Task(f"outside.{name}.{k}", {"names": [name], "outside_cause": True}) for k in range(2) for name in strange
    ]
    found += [Task(f"null.{k}", {"names": []}) for k in range(24)]
    found += [Task(f"wander.{k}", {"names": [], "wander": True}) for k in range(8)]
    found += [Task(f"number.{k}", {"names": [], "wrong": Wrong(1, 0.25, 0.5)}) for k in range(8)]
    found += [Task(f"pair.{k}", {"count": 2}) for k in range(200 - len(found))]
    return sorted(found, key=lambda task: _digest("order", task.name))


def sealed_seed(commit: str, checkout: Path) -> int:
    """The seed that belongs to a commit; CalledProcessError where git does not know it."""
    words = ["git", "rev-parse", "--verify", f"{commit}^{{commit}}"]
    done = subprocess.run(words, cwd=checkout, capture_output=True, text=True, check=True)
    return _digest("naming", done.stdout.strip()) % 2**62


def fingerprint() -> str:
    """Of the list: a test holds it, so that a case does not change by accident."""
    return hashlib.sha256("\n".join(f"{task.name} {task.arguments}" for task in all_tasks()).encode()).hexdigest()[:16]
