"""Laws that are hidden in the second antenna, told from the logs alone: `python -m tests.laws.run --each 2 --out FILE`.

With `--whole` the whole workflow runs first, and a law is told only where no name fits; without it the laws alone are
asked, beside the model with its known numbers moved. `--nulls N` and `--catalogue N` are antennas on which a law told
is a false one: every second null has friction that wanders, every third a weak field over the travel; of an effect of
the catalogue, laws are asked beside the best that names did, as if none of them stood.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from gimbal_hil.knowledge.discrepancy import Kind, Request, diagnose
from gimbal_hil.knowledge.discrepancy.inquiry import LEAST_GAP, rms
from gimbal_hil.knowledge.discrepancy.judgement import beyond_noise
from gimbal_hil.knowledge.discrepancy.laws import Described, DescribedLaw, described
from gimbal_hil.knowledge.discrepancy.run import _begun
from gimbal_hil.knowledge.discrepancy.search import explain
from gimbal_hil.knowledge.executor import open_executor
from tests.blind.cases import model_of, tables_of
from tests.blind.draw import Case, Unstable, draw
from tests.laws.kinds import KINDS, Told, laws

_DURATION_S = 24.0


def drawn(name: str, seed: int, magnitude: float = 15.0) -> Case:
    """An antenna with one law of a kind; "null" and "catalogue" have none."""
    axis = ("outer", "inner")[seed % 2]
    if name == "null":
        return draw(seed, [], duration_s=_DURATION_S, wander=seed % 2 == 1, field_on_null=seed % 3 == 2)
    if name == "catalogue":
        return draw(seed, magnitude=magnitude, duration_s=_DURATION_S)
    return draw(seed, [name], axis=axis, magnitude=magnitude, duration_s=_DURATION_S, pool=laws)


def looked_at(case: Case, whole: bool, beside_names: bool = False) -> dict[str, Any]:
    """What is told of a case: its laws, what is left, and the processor time that laws took."""
    request = Request(model_of(case), tables_of(case.measured, case.axes), tables_of(case.holdout, case.axes))
    with open_executor(1, None) as executor:
        if whole:
            began = time.process_time()
            result = diagnose(request)
            verdict, found, before = result.decision.kind.value, result.described, rms(result.null.untouched)
        else:
            begun = _begun(request, request.measured, request.holdout, executor, lambda text: None)
            began = time.process_time()
            named = explain(begun.inquiry, begun.null).state if beside_names else None
            began = time.process_time()
            lacking = beyond_noise(begun.inquiry, begun.null)
            found, before = described(begun.inquiry, begun.null, lacking, named), rms(begun.null.untouched)
            verdict = Kind.UNEXPLAINED.value if found is None else Kind.DESCRIBED.value
    took = time.process_time() - began
    left = [] if found is None else rms(found.state.untouched).round(2).tolist()
    return {"verdict": verdict, "laws": _laws(found), "before": before.round(2).tolist(), "left": left, "cpu_s": took}


def _laws(found: Described | None) -> list[dict[str, Any]]:
    told = () if found is None else found.laws
    return [
        {
            "axis": law.curve.shape.axis,
            "told": _told(law.curve.shape),
            "gain": round(law.gain, 3),
            "control": round(law.control, 3),
            "knots": [len(knots) for knots in law.curve.knots],
            "form": None if law.formula is None else law.formula.text,
            "phrase": None if law.formula is None else law.formula.phrase,
            "alike": [] if law.formula is None else list(law.formula.alike),
            "numbers": {} if law.formula is None else law.formula.numbers(False),
            "drawn": [[np.round(part, 6).tolist() for part in line[1:]] for line in law.curve.lines()],
            "drawn_formula": [part.tolist() for part in _drawn(law)],
        }
        for law in told
    ]


def _drawn(law: DescribedLaw) -> tuple[np.ndarray, ...]:
    """The formula at the places at which the curve is drawn; nothing where there is none, or it has two variables."""
    if law.formula is None or len(law.curve.shape.over) == 2:
        return ()
    return tuple(np.round(part, 6) for part in law.formula.at(law.curve.lines()[0].x))


def _told(shape: Any) -> Told:
    return shape.acts_on.value, tuple(one.value for one in shape.over), shape.by_direction


def is_right(name: str, axis: str, said: dict[str, Any]) -> bool:
    """Whether the law that takes most is of the axis and over the variables of the hidden one."""
    if not said["laws"]:
        return False
    most = max(said["laws"], key=lambda law: law["gain"])
    acts_on, over, by_direction = most["told"]
    return most["axis"] == axis and (acts_on, tuple(over), by_direction) in KINDS[name].right


def has_right_form(name: str, said: dict[str, Any]) -> bool:
    """Whether the formula of the law that takes most has the hidden one's form, or these data do not tell it."""
    if not said["laws"]:
        return False
    most = max(said["laws"], key=lambda law: law["gain"])
    return any(phrase in (most["phrase"], *most["alike"]) for phrase in KINDS[name].forms)


def main(arguments: list[str]) -> int:
    """Run the bench and print its counts; rows go to --out as JSON lines."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--each", type=int, default=2)
    parser.add_argument("--nulls", type=int, default=0)
    parser.add_argument("--catalogue", type=int, default=0)
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--seed", type=int, default=7000)
    parser.add_argument("--whole", action="store_true")
    parser.add_argument("--out", type=Path, required=True)
    asked = parser.parse_args(arguments)
    jobs = [(kind, i) for i in range(asked.each) for kind in asked.kinds.split(",") if kind]
    jobs += [("null", i) for i in range(asked.nulls)] + [("catalogue", i) for i in range(asked.catalogue)]
    counts: Counter[str] = Counter()
    with asked.out.open("a") as out:
        for name, i in jobs:
            seed = asked.seed + i
            try:
                case = drawn(name, seed)
            except Unstable:
                counts["not drawn"] += 1
                continue
            said = looked_at(case, asked.whole, name == "catalogue")
            row: dict[str, Any] = {"kind": name, "seed": seed, "whole": asked.whole, **said}
            if name in KINDS:
                axis = str(case.truth["causes"][0]["axis"])  # type: ignore[index]
                right = is_right(name, axis, said)
                row |= {"axis": axis, "right": right, "right_form": right and has_right_form(name, said)}
                row |= {"truth": case.truth["causes"][0]}  # type: ignore[index]
                if float(np.max(said["before"])) <= LEAST_GAP:
                    # the half that judges does not see it, so nothing may be told
                    counts["not shown where it is judged"] += 1
                    print(json.dumps(row | {"shown": False}), file=out, flush=True)
                    continue
                counts["laws"] += 1
                counts["described"] += bool(said["laws"])
                counts["right variables"] += right
                counts["right form"] += row["right_form"]
                counts["at most 1.5 floors"] += bool(said["left"]) and float(np.max(said["left"])) <= 1.5
            else:
                row |= {"truth": case.truth["causes"]}
                counts[name] += 1
                counts[f"{name}, a law told"] += bool(said["laws"])
            print(json.dumps(row), file=out, flush=True)
    print(json.dumps(counts, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
