"""The bench's tables: outcome by kind and by magnitude, parameters, closed gaps, wall times, and every case that went wrong."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from tests.blind.score import Outcome, outcome, parameter_errors

#: floors at which a cause counts as small, medium and large; below the first it cannot be asked for
CLASSES = (("below 2 floors", 0.0), ("small (2 to 5)", 2.0), ("medium (5 to 15)", 5.0), ("large (over 15)", 15.0))
#: kinds of cases that are not one effect of the catalogue
_KINDS = ("null", "pair", "outside", "floating_null", "floating", "rotary", "linear")
SECONDS_FILE = "seconds.txt"


def result(name: str, truth: dict[str, Any], verdict: dict[str, Any], seconds: float) -> dict[str, Any]:
    """What the tables need of one case."""
    gap = verdict["gap"] or {}
    return {
        "case": name, "outcome": outcome(truth, verdict).name, "verdict": verdict["verdict"], "seconds": round(seconds, 1),
        "hidden": [[c["name"], c["axis"], round(float(c["magnitude_floors"]), 2)] for c in truth["causes"]],
        "named": [[e["name"], e["axis"], e["status"]] for e in verdict["effects"]],
        "alternatives": [[a["name"], a["axis"]] for a in verdict["alternatives"]],
        "untestable": [[n["name"], n["axis"]] for n in verdict["not_testable"]],
        "parameters": [[name, round(error, 5), covered] for name, error, covered in parameter_errors(truth, verdict)],
        "closed": gap.get("closed_fraction"), "before_floors": gap["before"] / gap["noise_floor"] if gap else None,
        "after_floors": gap["after"] / gap["noise_floor"] if gap else None,
    }  # fmt: skip


def results(folder: Path, names: list[str]) -> list[dict[str, Any]]:
    """Every case of the list that has been judged in a folder."""
    found = []
    for name in names:
        files = [folder / name / file for file in ("truth.json", "verdict.json", SECONDS_FILE)]
        if all(file.exists() for file in files):
            truth, verdict, seconds = (file.read_text(encoding="utf-8") for file in files)
            found.append(result(name, json.loads(truth), json.loads(verdict), float(seconds)))
    return found


def kind_of(case: dict[str, Any]) -> str:
    """null, pair, outside, floating, rotary, linear, or single for one effect on the antenna."""
    first = str(case["case"]).split(".")[0]
    return first if first in _KINDS else "single"


def magnitude_class(case: dict[str, Any]) -> str:
    """Class of the weakest hidden cause."""
    least = min((h[2] for h in case["hidden"]), default=0.0)
    # a draw so small that its own magnitude could not be read counts as nothing
    return [name for name, start in CLASSES if start == 0.0 or least >= start][-1]


def _share(part: int, whole: int) -> str:
    return f"{part}/{whole} ({100.0 * part / whole:.1f} %)" if whole else "-"


def _outcomes(rows: list[tuple[str, list[dict[str, Any]]]], title: str) -> list[str]:
    lines = [f"| {title} | cases | " + " | ".join(o.value for o in Outcome) + " |", "|---" * (2 + len(Outcome)) + "|"]
    for name, cases in rows:
        counts = Counter(c["outcome"] for c in cases)
        lines.append(f"| {name} | {len(cases)} | " + " | ".join(str(counts[o.name]) for o in Outcome) + " |")
    return lines


def _targets(cases: list[dict[str, Any]]) -> list[str]:
    def these(*kinds: str) -> list[dict[str, Any]]:
        return [c for c in cases if kind_of(c) in kinds]

    def good(chosen: list[dict[str, Any]], *outcomes: str) -> str:
        return _share(sum(c["outcome"] in outcomes for c in chosen), len(chosen))

    single = these("single", "rotary", "linear")
    strong = [c for c in single if magnitude_class(c).startswith(("medium", "large"))]
    small = [c for c in single if magnitude_class(c).startswith("small")]
    below = [c for c in single if magnitude_class(c).startswith("below")]
    pairs = [c for c in these("pair") if not magnitude_class(c).startswith("below")]
    nulls, away = these("null", "floating_null"), these("outside")
    rows = [
        ("exact name and axis, medium and large", "95 %", good(strong, "EXACT")),
        ("... or the class with the run that separates", "97 %", good(strong, "EXACT", "CLASS")),
        ("small: name or class", "85 %", good(small, "EXACT", "CLASS")),
        ("below 2 floors: rightly named, or nothing named", "-", good(below, "EXACT", "CLASS", "MISSED")),
        ("nulls without a name", "99.5 %", good(nulls, "ABSTAINED")),
        ("outside the catalogue: abstains", "95 %", good(away, "ABSTAINED")),
        ("pairs (both at least 2 floors): both names", "90 %", good(pairs, "EXACT", "CLASS")),
        ("known numbers 8 % off: name or class", "97 %", good(these("floating"), "EXACT", "CLASS")),
    ]
    named = [c for c in cases if c["outcome"] == "EXACT" and c["closed"] is not None]
    closed = np.array([c["closed"] for c in named])
    rows.append(("closed fraction at least 0.95 (rightly named, untouched rows)", "-", _share(int(np.sum(closed >= 0.95)), len(closed))))
    errors = [p for c in cases if c["outcome"] == "EXACT" for p in c["parameters"]]
    rows.append(("parameters within 10 %", "100 %", _share(sum(e < 0.1 for _, e, _ in errors), len(errors))))
    rows.append(("intervals that cover the truth", "90 %", _share(sum(bool(k) for _, _, k in errors), len(errors))))
    return ["| figure | target | reached |", "|---|---|---|", *(f"| {a} | {b} | {c} |" for a, b, c in rows)]


def tables(folder: Path, names: list[str]) -> str:
    """The results page's tables, in Markdown."""
    cases = results(folder, names)
    kinds: dict[str, list[dict[str, Any]]] = {}
    effects: dict[str, list[dict[str, Any]]] = {}
    for case in cases:
        kinds.setdefault(kind_of(case), []).append(case)
        if kind_of(case) == "single":
            effects.setdefault(case["hidden"][0][0], []).append(case)
    alone = [c for c in cases if kind_of(c) in ("single", "rotary", "linear")]
    classes = [(name, [c for c in alone if magnitude_class(c) == name]) for name, _ in CLASSES]
    seconds = np.array([c["seconds"] for c in cases] or [0.0])
    wrong = [c for c in cases if c["outcome"] in ("MISSED", "PARTLY", "FALSE")]
    lines = [
        f"{len(cases)} of {len(names)} cases judged; wall time of one: median {np.median(seconds):.0f} s, longest {seconds.max():.0f} s.",
        "",
        *_targets(cases), "", *_outcomes(sorted(kinds.items()), "kind"), "", *_outcomes(classes, "one cause, by magnitude"), "",
        *_outcomes(sorted(effects.items()), "effect (antenna, both axes)"), "", "| gone wrong | hidden (floors) | said | gap in floors |",
        "|---|---|---|---|",
    ]  # fmt: skip
    for c in wrong:
        hidden = ", ".join(f"{n} {a} ({m:g})" for n, a, m in c["hidden"]) or "nothing"
        said = ", ".join(f"{n} {a}" for n, a, _ in c["named"]) or c["verdict"]
        lines.append(f"| {c['case']} | {hidden} | {said} | {c['before_floors']:.1f} to {c['after_floors']:.1f} |")
    return "\n".join(lines)
