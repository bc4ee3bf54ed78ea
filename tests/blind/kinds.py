"""The bench's list of cases. Every case is drawn from (bench seed, its name), so that another seed is a whole fresh
bench.
"""

from __future__ import annotations

import hashlib
import subprocess
from collections import Counter
from dataclasses import dataclass, field
from enum import Enum
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

from firmware_protocol.errors import BadInputError
from tests.blind.causes import catalogue, outside
from tests.blind.draw import Wrong
from tests.blind.guests import SOURCES as GUESTS
from tests.blind.rig import STRANGERS

#: what rules are decided on; figures that are told come from other seeds
DECIDE_SEED = 0


class Stated(Enum):
    """What a model file says about how well its numbers are known."""

    SHIPPED = "the shipped thesis model, as it stands"
    EXACT = "0.1 % for all"
    MEASURED = "source: measured"
    CAD = "source: CAD"
    NOTHING = "nothing"


@dataclass(frozen=True)
class Job:
    """One case of the bench: its name (the kind first), what `draw` is called with, what its model file says of
    itself.
    """

    name: str
    arguments: dict[str, Any] = field(default_factory=dict)
    stated: Stated = Stated.SHIPPED
    #: an effect that is plugged in for this case
    guest: str | None = None

    @property
    def kind(self) -> str:
        """The first word of the name."""
        return self.name.split(".")[0]

    def seed(self, bench_seed: int) -> int:
        """Seed of this case on a bench."""
        return _digest(bench_seed, "case", self.name) % 2**63

    def order(self, bench_seed: int) -> int:
        """Where it comes: in an order that mixes the kinds, so that an interrupted bench has seen some of each."""
        return _digest(bench_seed, "order", self.name)


def _digest(*words: object) -> int:
    return int.from_bytes(hashlib.sha256("/".join(map(str, words)).encode()).digest()[:16], "big")


def sealed_seed(release: str, folder: Path) -> int:
    """The seed that belongs to a release: from the hash of its commit, which nobody knows before that commit is
    made.
    """
    done = subprocess.run(
        ["git", "rev-parse", "--verify", "--quiet", f"{release}^{{commit}}"], cwd=folder, capture_output=True, text=True
    )
    if done.returncode or not done.stdout.strip():
        raise BadInputError("--sealed", f"git knows no release {release!r}", "a tag or commit of this checkout")
    return _digest("sealed", done.stdout.strip()) % 2**63


_SINGLE_AXIS = (
    "cogging",
    "coulomb",
    "stribeck",
    "cable_spring",
    "viscous_asymmetry",
    "inertia",
    "torque_offset",
    "quadratic_drag",
)


def all_jobs() -> list[Job]:
    """Every case of a whole bench, kind by kind."""
    rng = np.random.default_rng(0)
    effects = [c.name for c in catalogue(rng, "outer", 0)]
    strangers = [c.name for c in outside(rng, "outer")]
    found = [
        Job(f"single.{name}.{axis}.{k}", {"names": [name], "axis": axis})
        for k in range(3) for name in effects for axis in ("outer", "inner")
    ]  # fmt: skip
    found += [Job(f"null.{i}", {"names": [], "field_on_null": i % 2 == 1}) for i in range(100)]
    found += [Job(f"wander.{i}", {"names": [], "wander": True}) for i in range(100)]
    found += [Job(f"pair.{i}", {"count": 2}) for i in range(60)]
    found += [Job(f"triple.{i}", {"apart": True, "count": 3}) for i in range(40)]
    found += [Job(f"faint.{i}", {"magnitude": 1.5}) for i in range(50)]
    found += [
        Job(f"outside.{name}.{axis}.{k}", {"names": [name], "axis": axis, "outside_cause": True})
        for k in range(2) for name in strangers for axis in ("outer", "inner")
    ]  # fmt: skip
    far = Wrong(2, 0.25, 0.25)
    for i in range(40):
        stated = Stated.CAD if i % 2 else Stated.NOTHING
        found.append(Job(f"cad.{i}", {"names": [], "rig": "plain", "wrong": Wrong(5, 0.20, 0.33)}, stated))
        found.append(Job(f"known.{i}", {"rig": "plain", "off": 0.10, "wrong": far}, Stated.MEASURED))
    for i in range(20):
        found.append(Job(f"floating_null.{i}", {"names": [], "rig": "plain", "off": 0.08}, Stated.MEASURED))
        found.append(Job(f"floating.{i}", {"rig": "plain", "off": 0.08}, Stated.MEASURED))
    for name in _SINGLE_AXIS:
        found.append(Job(f"rotary.{name}", {"names": [name], "rig": "rotary", "axis": "outer"}, Stated.EXACT))
        found.append(Job(f"linear.{name}", {"names": [name], "rig": "linear", "axis": "outer"}, Stated.EXACT))
    for name in GUESTS:
        for axis in ("outer", "inner"):
            arguments = {"names": [name], "axis": axis, "outside_cause": True, "plugged_in": True}
            found += [Job(f"guest.{name}.{axis}.{i}", arguments, guest=name) for i in range(5)]
    for rig in STRANGERS:
        # one in four has nothing hidden
        found += [
            Job(f"stranger.{rig}.{i}", {"rig": rig} | ({"names": []} if i % 4 == 3 else {}), Stated.EXACT)
            for i in range(8)
        ]
    return found


KINDS = tuple(dict.fromkeys(job.kind for job in all_jobs()))


@dataclass(frozen=True)
class Part:
    """Which cases of a bench are wanted: of these kinds, of names like this pattern, at most so many of a kind, so many
    in all.
    """

    kinds: tuple[str, ...] = ()
    like: str = "*"
    most: int | None = None
    first: int | None = None


def jobs(bench_seed: int, part: Part | None = None) -> list[Job]:
    """The cases of a bench, or of a part of it, in mixed order; a case of a kind comes at the same place whatever the
    part.
    """
    part = part or Part()
    for kind in part.kinds:
        if kind not in KINDS:
            raise BadInputError("--kinds", f"no kind {kind!r}", ", ".join(KINDS))
    found = [
        job for job in all_jobs() if (not part.kinds or job.kind in part.kinds) and fnmatchcase(job.name, part.like)
    ]
    if not found:
        raise BadInputError("--cases", f"no case is like {part.like!r}", "a pattern such as 'single.cogging.*'")
    counted: Counter[str] = Counter()
    chosen = []
    for job in sorted(found, key=lambda job: job.order(bench_seed)):
        counted[job.kind] += 1
        if part.most is None or counted[job.kind] <= part.most:
            chosen.append(job)
    return chosen[: part.first]
