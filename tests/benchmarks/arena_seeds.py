"""Controllers of the arena over many seeds: mean, spread, and the best of the others seed by seed.

    python -m tests.benchmarks.arena_seeds --seeds 20 --controller tuned --controller model_cascade --out seeds.jsonl

Every trial is a line of the file as it ends: an interrupted campaign goes on with the same command, more seeds or
controllers later add to it, and `--table` only prints what there is. The table compares `--judged` with every other
controller that is not of its own kind, on the seeds that both have.
"""

from __future__ import annotations

import argparse
import json
import statistics
from pathlib import Path

from gimbal_hil.pointing.arena import Scenario, Trial, entrants, run_trial, shipped_scenarios
from sim_backend.model import model_named

ANTENNA = "realistic"
#: what `tune` makes, and more parts of it: no rivals of each other
OWN = ("tuned", "tuned_pointing", "tuned_both", "levels", "learned")
#: by scenario and controller: line-of-sight error in urad rms by seed, None where a guard stopped it
Found = dict[tuple[str, str], dict[int, float | None]]


def read(path: Path) -> Found:
    """What a file has."""
    found: Found = {}
    for line in path.read_text().splitlines() if path.exists() else []:
        scenario, controller, seed, urad = json.loads(line)
        found.setdefault((scenario, controller), {})[seed] = urad
    return found


def rows(words: list[str]) -> list[Scenario]:
    """Shipped scenarios, steps apart, whose names have any of the words."""
    kept = [one for one in shipped_scenarios() if one.axis is None]
    return [one for one in kept if not words or any(word in one.name for word in words)]


def table(found: Found, judged: str) -> str:
    """Markdown: a row for each scenario, the hardest first."""
    names = list(dict.fromkeys(controller for _, controller in found))
    others = [name for name in names if name != judged and name not in OWN]
    lines = []
    for scenario in dict.fromkeys(scenario for scenario, _ in found):
        own = found.get((scenario, judged), {})
        cells = [cell(found.get((scenario, name), {})) for name in names]
        ratios = [one for name in others if (one := ratio(own, found.get((scenario, name), {}))) is not None]
        values = [value for value in own.values() if value is not None]
        hardest = statistics.fmean(values) if values else 0.0
        lines.append((hardest, f"| {scenario} | {' | '.join(cells)} | {max(ratios, default=float('nan')):.2f} |"))
    head = f"| row | {' | '.join(names)} | {judged} over the best of the others |"
    return "\n".join([head, "|---" * (len(names) + 2) + "|", *(line for _, line in sorted(lines, reverse=True))])


def cell(by_seed: dict[int, float | None]) -> str:
    """Mean +- one standard deviation, and of how many seeds."""
    values = [value for value in by_seed.values() if value is not None]
    stopped = f", {len(by_seed) - len(values)} stopped" if len(values) < len(by_seed) else ""
    if not values:
        return "-" if not by_seed else f"all {len(by_seed)} stopped"
    spread = f" +- {statistics.stdev(values):.3g}" if len(values) > 1 else ""
    return f"{statistics.fmean(values):.4g}{spread} ({len(values)}{stopped})"


def ratio(own: dict[int, float | None], other: dict[int, float | None]) -> float | None:
    """Of the means over the seeds that both have; None without such seeds."""
    pairs = [(own[seed], other[seed]) for seed in own.keys() & other.keys()]
    both = [(a, b) for a, b in pairs if a is not None and b is not None]
    return sum(a for a, _ in both) / sum(b for _, b in both) if both else None


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--controller", action="append", default=[])
    parser.add_argument("--scenario", action="append", default=[], help="words of names; without it all but steps")
    parser.add_argument("--first", type=int, default=1, help="first seed")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--judged", default="tuned")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--table", action="store_true", help="only print")
    asked = parser.parse_args()
    found = read(asked.out)
    if not asked.table:
        model, chosen = model_named(ANTENNA), entrants(asked.controller)
        with asked.out.open("a") as file:
            for seed in range(asked.first, asked.first + asked.seeds):
                for scenario in rows(asked.scenario):
                    for one in chosen:
                        if seed in found.get((scenario.name, one.name), {}):
                            continue
                        trial = Trial(scenario, one.name, one.settings, ANTENNA, model, seed, law=one.law)
                        outcome = run_trial(trial)
                        urad = None if outcome.tripped else 1e6 * outcome.los_rms
                        file.write(json.dumps([scenario.name, one.name, seed, urad]) + "\n")
                        file.flush()
        found = read(asked.out)
    print(table(found, asked.judged))


if __name__ == "__main__":
    main()
