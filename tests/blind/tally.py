"""The bench's tables: figures beside their targets, outcomes by kind, magnitude and effect, and every case that went
wrong.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from typing import Any

import numpy as np

from tests.blind.figures import CLASSES, Bin, CaseResult, Share, class_reliability, reliability, share
from tests.blind.score import GOOD, Outcome

_SINGLE = ("single", "rotary", "linear")
Row = tuple[str, str, str]


def _of(cases: list[CaseResult], *kinds: str) -> list[CaseResult]:
    return [c for c in cases if c.kind in kinds]


def _seen(cases: list[CaseResult]) -> list[CaseResult]:
    return [c for c in cases if c.least_floors >= CLASSES[1][1]]


def targets(cases: list[CaseResult]) -> list[Row]:
    """(figure, target, reached)."""
    exact, either = (Outcome.EXACT,), (Outcome.EXACT, Outcome.CLASS)
    single = _of(cases, *_SINGLE)
    strong = [c for c in single if c.magnitude.startswith(("medium", "large"))]
    small = [c for c in single if c.magnitude.startswith("small")]
    nulls, away = _of(cases, "null", "wander", "floating_null"), _of(cases, "outside")
    triples, faint = _of(cases, "triple"), _of(cases, "faint")
    cad, known = _of(cases, "cad"), _of(cases, "known")
    pairs, strangers = _seen(_of(cases, "pair")), _of(cases, "stranger")
    hidden = [c for c in strangers if c.hidden]
    rows = [
        ("medium and large: exact name and axis", "97 %", share(strong, *exact)),
        ("... or the class with the run that separates", "98 %", share(strong, *either)),
        ("small: name or class", "85 %", share(small, *either)),
        ("pairs (both at least 2 floors): both names", "92 %", share(pairs, *either)),
        ("three at once: all named", "80 %", share(_seen(triples), *either)),
        ("three at once: none false", "100 %", _clean(triples)),
        ("1.5 floors: none false", "100 %", _clean(faint)),
        ("nulls: none named", "100 %", Share(sum(all(s != "named" for _, _, s in c.named) for c in nulls), len(nulls))),
        ("nulls with nothing hidden: `no_discrepancy`", "90 %", _silent([c for c in nulls if not c.hidden])),
        ("... of those with a wandering level", "90 %", _silent(_of(cases, "wander"))),
        ("nulls with a field of 0.5 to 1.2 floors: `no_discrepancy`", "-", _silent([c for c in nulls if c.hidden])),
        ("outside the catalogue: abstains", "97 %", share(away, Outcome.ABSTAINED, Outcome.GUESSED)),
        ("... or the catalogue's nearest name", "-", share(away, Outcome.ABSTAINED, Outcome.GUESSED, Outcome.AKIN)),
        ("five numbers 20 to 33 % off: all of them named, no phantom", "97 %", share(cad, *either)),
        ("... each number that shows: named", "-", _numbers(cad, 1)),
        ("... or recalibrated to within 10 %", "-", _numbers(cad, 2)),
        ("... no phantom beside them", "100 %", _clean(cad)),
        ("numbers 10 and 25 % off, one effect: effect and far numbers", "97 %", share(_seen(known), *either)),
        ("... the far ones named", "97 %", _numbers(known, 1)),
        ("... no phantom", "100 %", _clean(known)),
        (
            "... none of those within what the model says of them",
            "-",
            Share(sum(not c.near for c in known), len(known)),
        ),
        ("numbers 8 % off, one effect: name or class", "97 %", share(_seen(_of(cases, "floating")), *either)),
        ("strangers' antennas, one effect: name or class", "97 %", share(_seen(hidden), *either)),
        ("strangers' antennas: none false", "100 %", _clean(strangers)),
        ("a plugged-in effect: name or class", "-", share(_seen(_of(cases, "guest")), *either)),
        ("an answer at all", "100 %", Share(sum(c.outcome is not Outcome.NO_ANSWER for c in cases), len(cases))),
    ]
    return [(a, b, str(c)) for a, b, c in rows] + _of_named(cases)


def _clean(cases: list[CaseResult]) -> Share:
    return Share(sum(not c.has_phantom or c.outcome is Outcome.CLASS for c in cases), len(cases))


def _silent(cases: list[CaseResult]) -> Share:
    return Share(sum(c.verdict == "no_discrepancy" for c in cases), len(cases))


def _numbers(cases: list[CaseResult], which: int) -> Share:
    found = [bool(n[which]) for c in cases for n in c.numbers]
    return Share(sum(found), len(found))


def _of_named(cases: list[CaseResult]) -> list[Row]:
    closed = [c.closed for c in cases if c.outcome is Outcome.EXACT and c.closed is not None]
    errors = [p for c in cases if c.outcome is Outcome.EXACT for p in c.parameters]
    ninety = [right for c in cases for _, _, p, right in c.told if p is not None and 0.85 <= p < 0.95]
    wall, cpu = np.array([c.seconds for c in cases] or [0.0]), np.array([c.cpu_seconds for c in cases] or [0.0])
    return [
        (
            "closed fraction at least 0.95 (rightly named, untouched rows)",
            "-",
            str(Share(sum(x >= 0.95 for x in closed), len(closed))),
        ),
        ("parameters within 10 %", "100 %", str(Share(sum(e < 0.1 for _, e, _ in errors), len(errors)))),
        ("intervals that cover the truth", "90 to 98 %", str(Share(sum(k for _, _, k in errors), len(errors)))),
        ("names told at 85 to 95 %: right", "85 to 95 %", str(Share(sum(ninety), len(ninety)))),
        ("a case on the wall clock: median, longest", "15 s", f"{np.median(wall):.0f} s, {wall.max():.0f} s"),
        ("... of one processor", "-", f"{np.median(cpu):.0f} s, {cpu.max():.0f} s"),
    ]


TOLD_NAMES, TOLD_CLASSES = "told probability of a name", "told probability that the class holds it (1 - something_else)"


def reliability_rows(bins: list[Bin]) -> list[tuple[str, str, str, str]]:
    """(told range, mean told, right, interval) of every bin."""
    return [
        (f"{b.low:g} to {b.high:g}", f"{b.told:.3f}", f"{b.right.part}/{b.right.whole} ({100 * b.right.value:.1f} %)",
         "{:.0f} to {:.0f} %".format(*(100 * x for x in b.right.interval)))
        for b in bins
    ]  # fmt: skip


def outcome_groups(cases: list[CaseResult]) -> list[tuple[str, list[tuple[str, list[CaseResult]]]]]:
    """(title, rows of cases) by kind, by magnitude, by effect, outside the catalogue, by stranger."""
    alone = _of(cases, *_SINGLE)
    return [
        ("kind", _grouped(cases, lambda c: c.kind)),
        ("one cause, by magnitude", [(name, [c for c in alone if c.magnitude == name]) for name, _ in CLASSES]),
        ("effect (antenna, both axes)", _grouped(_of(cases, "single"), lambda c: c.hidden[0][0])),
        ("outside the catalogue", _grouped(_of(cases, "outside"), lambda c: c.hidden[0][0])),
        ("strangers' antennas", _grouped(_of(cases, "stranger"), lambda c: c.name.split(".")[1])),
        ("five wrong numbers, by what the model file says of them", _grouped(_of(cases, "cad"), lambda c: c.stated)),
    ]


def _grouped(cases: list[CaseResult], key: Any) -> list[tuple[str, list[CaseResult]]]:
    found: dict[str, list[CaseResult]] = {}
    for case in cases:
        found.setdefault(key(case), []).append(case)
    return sorted(found.items())


def gone_wrong(cases: list[CaseResult]) -> list[tuple[str, str, str, str]]:
    """(case, hidden, said, gap in floors) of every case that did not end as it should."""
    rows = []
    for c in cases:
        if c.outcome in GOOD:
            continue
        hidden = ", ".join(f"{n} {a} ({m:.2g})" for n, a, m in c.hidden) or "nothing"
        said = ", ".join(f"{n} {a}{'' if s == 'named' else '?'}" for n, a, s in c.named) or c.verdict
        gap = (
            f"{c.before_floors:.1f} to {c.after_floors:.1f}"
            if c.before_floors is not None and c.after_floors is not None
            else "-"
        )
        rows.append((c.name, hidden, said, gap))
    return sorted(rows)


def _markdown(header: tuple[str, ...], rows: list[tuple[str, ...]]) -> list[str]:
    return [
        "| " + " | ".join(header) + " |",
        "|---" * len(header) + "|",
        *("| " + " | ".join(row) + " |" for row in rows),
        "",
    ]


def outcome_rows(groups: list[tuple[str, list[CaseResult]]]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Header (without its first word) and rows of an outcome table; outcomes that did not come are left out."""
    seen = [o for o in Outcome if any(c.outcome is o for _, cases in groups for c in cases)]
    rows = []
    for name, cases in groups:
        counts = Counter(c.outcome for c in cases)
        rows.append((name, str(len(cases)), *(str(counts[o]) for o in seen)))
    return ("cases", *(o.value for o in seen)), rows


def told_of(cases: list[CaseResult], seed: int, sealed: str | None) -> str:
    """One line on which bench this is."""
    what = f"sealed with {sealed}" if sealed else f"seed {seed}"
    return f"{len(cases)} cases judged, {what}. Shares with their 95 % intervals."


def tables(cases: list[CaseResult], seed: int, sealed: str | None) -> str:
    """The results page's tables, in Markdown."""
    command = f"gimbal-hil bench blind --out FOLDER {'--sealed ' + sealed if sealed else f'--seed {seed}'}"
    lines = [
        "# Blind bench: results",
        "",
        f"Command: `{command}`; `--table` prints this page of what has been judged.",
        "",
    ]
    lines += [told_of(cases, seed, sealed), "", *_markdown(("figure", "target", "reached"), [*targets(cases)])]
    for title, bins in ((TOLD_NAMES, reliability(cases)), (TOLD_CLASSES, class_reliability(cases))):
        if bins:
            lines += _markdown((title, "mean told", "right", "95 % interval"), [*reliability_rows(bins)])
    for title, groups in outcome_groups(cases):
        if any(found for _, found in groups):
            header, rows = outcome_rows(groups)
            lines += _markdown((title, *header), rows)
    lines += _markdown(("gone wrong", "hidden (floors)", "said", "gap in floors"), [*gone_wrong(cases)])
    return "\n".join(lines)


def as_json(cases: list[CaseResult], seed: int) -> dict[str, Any]:
    """Every figure and every case for other tools."""
    bins = [
        {"low": b.low, "high": b.high, "told": b.told, "right": b.right.part, "of": b.right.whole}
        for b in reliability(cases)
    ]
    return {
        "seed": seed,
        "figures": [{"figure": a, "target": b, "reached": c} for a, b, c in targets(cases)],
        "reliability": bins,
        "cases": [asdict(c) | {"outcome": c.outcome.name, "kind": c.kind} for c in cases],
    }
