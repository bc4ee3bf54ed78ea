"""How often `changed` is silent where nothing changed, and tells what did, on machines of fresh seeds.

Two logs a side, each of its own trajectory, of one joint (`tests/change/rig.py`): its numbers are drawn, in half of the
draws the model lacks a ripple, a spring or a gain on both sides, and what a person believes of inertia, Coulomb level
and viscous friction is off by up to 10, 15 and 20 %.

    python -m tests.benchmarks.what_changed --draws 10 --out changed.jsonl [KIND...]
    python -m tests.benchmarks.what_changed --out changed.jsonl --draws 0

Finished draws stay in the file and are not made again; a line a draw is printed, then a table a kind.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from gimbal_hil.knowledge.change import compare, document_of
from tests.change.rig import Machine

#: what is planted, and the name that it should be told by
KINDS = {"null": None, "coulomb": "coulomb", "ripple": "cogging", "spring": "cable_spring", "gain": "torque_gain",
         "viscous": "viscous", "inertia": "inertia"}  # fmt: skip
FIRST_SEED = 8000
Draw = dict[str, Any]


def machines(kind: str, seed: int) -> tuple[Machine, Machine, Machine, str]:
    """The machine before, after, as it is believed to be, and what its model lacks on both sides."""
    random = np.random.default_rng([seed, list(KINDS).index(kind)])
    before = Machine(
        inertia=0.02 * random.uniform(0.75, 1.3),
        coulomb=0.05 * random.uniform(0.7, 1.4),
        viscous=0.02 * random.uniform(0.6, 1.5),
    )
    off = 1.0 + np.array([0.1, 0.15, 0.2]) * random.uniform(-1.0, 1.0, 3)
    believed = before.but(
        inertia=before.inertia * off[0], coulomb=before.coulomb * off[1], viscous=before.viscous * off[2]
    )
    lacks = str(random.choice(["", "", "", "ripple", "spring", "gain"]))
    before = before.but(**_lacking(lacks, random))
    return before, before.but(**_changed(kind, before, random)), believed, lacks


def _lacking(what: str, random: np.random.Generator) -> dict[str, float]:
    """What the model has not, before as after."""
    return {
        "": {},
        "ripple": {"ripple": random.uniform(0.006, 0.015), "order": float(random.integers(5, 13))},
        "spring": {"spring": random.uniform(0.02, 0.05)},
        "gain": {"gain": 1.0 + random.uniform(-0.12, 0.12)},
    }[what]


def _changed(kind: str, before: Machine, random: np.random.Generator) -> dict[str, float]:
    """What is other after, of a size that people ask about."""
    sign = random.choice([-1.0, 1.0])
    size = random.uniform(0.0, 1.0)
    return {
        "null": {},
        "coulomb": {"coulomb": before.coulomb * (1.0 + sign * (0.2 + 0.2 * size))},
        # of the order that it has already, or one that is new
        "ripple": {
            "ripple": before.ripple + 0.008 + 0.01 * size,
            "order": before.order if before.ripple else float(random.integers(5, 13)),
        },
        "spring": {"spring": before.spring + 0.025 + 0.03 * size},
        "gain": {"gain": before.gain * (1.0 + sign * (0.1 + 0.1 * size))},
        "viscous": {"viscous": before.viscous * (1.0 + sign * (0.3 + 0.2 * size))},
        "inertia": {"inertia": before.inertia * (1.0 + sign * (0.1 + 0.1 * size))},
    }[kind]


def draw(kind: str, seed: int) -> Draw:
    """One comparison."""
    before, after, believed, lacks = machines(kind, seed)
    random = np.random.default_rng([seed, 99])
    logs = before.logs(random), after.logs(random)
    begun = time.process_time()
    found = document_of(compare(believed.model(), *logs))
    effects = [
        {
            "name": entry["name"],
            "parameters": {
                name: [number[key] for key in ("nominal", "value", "low", "high")]
                for name, number in entry["parameters"].items()
            },
        }
        for entry in found["effects"]
    ]
    return {
        "kind": kind, "seed": seed, "lacks": lacks, "verdict": found["verdict"], "effects": effects,
        "dismissed": [(one["name"], one["reason"]) for one in found["dismissed"]],
        "before": found["before"]["verdict"], "after": found["after"]["verdict"], "left": found["left"],
        "was": vars(before), "is": vars(after), "processor_s": round(time.process_time() - begun, 1),
    }  # fmt: skip


def right(one: Draw) -> bool:
    """Silent where nothing changed; told by its name, and nothing else beside it, where something did."""
    names = {effect["name"] for effect in one["effects"]}
    planted = KINDS[one["kind"]]
    return one["verdict"] == "no_change" if planted is None else one["verdict"] == "changed" and names == {planted}


def summary(done: list[Draw]) -> str:
    """Figures by kind."""
    lines = []
    for kind in KINDS:
        some = [one for one in done if one["kind"] == kind]
        if not some:
            continue
        held = sum(map(right, some))
        others = Counter(
            f"{one['verdict']} {'+'.join(sorted(e['name'] for e in one['effects'])) or 'nothing'}"
            for one in some
            if not right(one)
        )
        seconds = np.median([one["processor_s"] for one in some])
        rest = "; ".join(f"{text} {count}" for text, count in others.items())
        lines.append(f"{kind}: right {held} of {len(some)}; {rest or 'no other'}; {seconds:.0f} s of processor each")
    return "\n".join(lines)


def main() -> None:
    """Draws what is not in the file yet, then prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kinds", nargs="*", default=list(KINDS))
    parser.add_argument("--draws", type=int, default=10)
    parser.add_argument("--seed", type=int, default=FIRST_SEED)
    parser.add_argument("--seconds", type=float, default=float("inf"), help="begin no draw after this time")
    parser.add_argument("--out", type=Path, default=Path("changed.jsonl"))
    asked = parser.parse_args()
    done = [json.loads(line) for line in asked.out.read_text().splitlines()] if asked.out.exists() else []
    have = {(one["kind"], one["seed"]) for one in done}
    begun = time.monotonic()
    for seed in range(asked.seed, asked.seed + asked.draws):
        for kind in asked.kinds:
            if (kind, seed) in have or time.monotonic() - begun > asked.seconds:
                continue
            done.append(draw(kind, seed))
            with asked.out.open("a") as file:
                file.write(json.dumps(done[-1]) + "\n")
            print({key: done[-1][key] for key in ("kind", "seed", "lacks", "verdict", "effects")}, right(done[-1]))
    print(summary(done))


if __name__ == "__main__":
    main()
