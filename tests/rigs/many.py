"""Many rigs asked about one after the other: what was said stays in a folder, so that an interrupted run goes on."""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.rigs.told import in_words

Said = dict[str, Any]


@dataclass(frozen=True)
class Chosen:
    """What a user asked for on the command line."""

    folder: Path
    seed: int
    rigs: int
    motions: tuple[str, ...]


def judged(said: Said, names: frozenset[str], axis: str) -> str:
    """How a verdict stands to what an axis has and its model has not. right: the name, and its axis; class: one that
    holds it; silent: no name; guessed: a guess where nothing of the catalogue is missing; false: another name beside it
    or instead.
    """
    if "error" in said:
        return "error"
    verdict = said["verdict"]
    told = {(one["name"], one["axis"]) for one in verdict["effects"] if one["status"] == "named"}
    classes = {(one["name"], one["axis"]) for one in (*verdict["effects"], *verdict["alternatives"])}
    right = {(name, axis) for name in names}
    if told - right:
        return "false"
    if told:
        return "right"
    if not names:
        return "right" if verdict["verdict"] in ("no_discrepancy", "unexplained") else "guessed"
    return "class" if classes & right else "silent"


def table(results: Mapping[str, Said]) -> str:
    """Markdown: every rig, and how many ended how."""
    lines = ["| rig | hidden | motion | said | judged | processor, s |", "|---|---|---|---|---|---|"]
    for name, said in sorted(results.items()):
        seconds = f"{said.get('cpu_s', float('nan')):.0f}"
        cells = (name, said["true"], said["motion"], in_words(said), said["judged"], seconds)
        lines.append(f"| {' | '.join(cells)} |")
    counts = Counter(said["judged"] for said in results.values())
    return "\n".join([*lines, "", ", ".join(f"{count} {word}" for word, count in counts.most_common())])


def ask_many(
    words: Sequence[str] | None,
    description: str | None,
    motions: Sequence[str],
    rigs: int,
    work_of: Callable[[Chosen], Mapping[str, tuple[Any, ...]]],
    asked: Callable[..., Said],
) -> None:
    """The command line: `asked(folder, name, *given)` for every rig of `work_of` that has not been asked yet."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rigs", type=int, default=rigs)
    parser.add_argument("--motions", default=motions[0], help=f"of {', '.join(motions)}: these in turn, comma between")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--table", action="store_true", help="only print what has been asked")
    read = parser.parse_args(words)
    chosen = Chosen(read.folder, read.seed, read.rigs, tuple(read.motions.split(",")))
    chosen.folder.mkdir(parents=True, exist_ok=True)
    kept = chosen.folder / "told.json"
    results = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    with ProcessPoolExecutor(read.workers) as pool:
        waiting = {
            pool.submit(asked, chosen.folder, name, *given): name
            for name, given in work_of(chosen).items()
            if name not in results and not read.table
        }
        for done in as_completed(waiting):
            name = waiting[done]
            results[name] = said = done.result()
            kept.write_text(json.dumps(results, indent=1), encoding="utf-8")
            print(name, "|", said["true"], "|", in_words(said), "|", said["judged"], flush=True)
    print(table(results))
