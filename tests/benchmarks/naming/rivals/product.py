"""gimbal-hil itself, as its command line: `discrepancy` on the two measured logs, the second held out.

Names and probabilities are its verdict's. What they are worth on the challenge is fitted with the columns of the other
rivals, so that the same equation judges all.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from tests.benchmarks.naming.rivals.answers import equations, write_answer
from tests.benchmarks.naming.rivals.columns import Case, read_case
from tests.benchmarks.naming.tables import write_csv

_LAW = {
    "Ts": "breakaway",
    "Tc": "coulomb",
    "vs": "stribeck_velocity",
    "delta": "shape",
    "s0": "sigma0",
    "s1": "sigma1",
    "s2": "viscous",
}
_TENSOR = ("xx", "yy", "zz", "xy", "xz", "yz")


def model_of(about: dict[str, Any]) -> str:
    """A model file of the known numbers, exact to a thousandth as they are."""
    axes: dict[str, Any] = {}
    for k, name in enumerate(about["axes"]):
        row = about["bodies"][name]
        inertia = dict(zip(_TENSOR, row[:6], strict=True))
        axes[name] = {
            "body": {"mass": row[9], "cog": dict(zip("xyz", row[6:9], strict=True)), "inertia": inertia},
            "friction": {key: about["friction"][name][short] for short, key in _LAW.items()},
            "actuator": {"limit": about["torque_limits"][k]},
            "encoder": {"step": about["encoder_step"]},
        }
    if len(axes) == 2:
        axes[about["axes"][1]]["parent"] = about["axes"][0]
    return json.dumps({"schema": 1, "name": "bench", "kind": "gimbal", "uncertainty": "0.1%", "axes": axes})


def verdict_of(case: Case, kept: Path) -> dict[str, Any]:
    """What the command says; its verdict and model stay in `kept`, to be looked at."""
    program = shutil.which("gimbal-hil")
    if program is None:
        raise SystemExit("gimbal-hil is not installed here: pip install gimbal-hil")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "model.yaml").write_text(model_of(case.about))
        for k, log in enumerate(case.measured):
            shown = {name: column for name, column in log.raw.items() if not name.endswith(("_model", "_filtered"))}
            write_csv(folder / f"{k}.csv", shown)
        words = [program, "discrepancy", "--model", "model.yaml", "--measured", "0.csv", "--holdout", "1.csv"]
        subprocess.run([*words, "--out", "out", "--workers", "1", "--json"], cwd=folder, check=True)
        for name in ("verdict.json", "model.yaml"):
            if (folder / "out" / name).exists():
                shutil.copy(folder / "out" / name, kept)
        return dict(json.loads((kept / "verdict.json").read_text()))


def said(column: str, axis: str, verdict: dict[str, Any]) -> bool:
    """Whether the verdict has this column, and of a ripple's its order or one that it lies between."""
    name, _, order = column.partition("#")
    found = [one["parameters"] for one in verdict["effects"] if (one["name"], one["axis"]) == (name, axis)]
    return any(not order or abs(numbers["order"]["value"] - int(order)) < 1.0 for numbers in found)


def told_by(verdict: dict[str, Any]) -> dict[tuple[str, str], float]:
    """Probability by name and axis. What it calls ambiguous it does not say: that is less likely than not, and its
    alternatives share what their class has beyond it.
    """
    told: dict[tuple[str, str], float] = {}
    for one in verdict["effects"]:
        own = one["probability"] if one["status"] == "named" else min(one["probability"], 0.49)
        told[one["name"], one["axis"]] = own
        others = [
            (other["name"], other["axis"])
            for other in verdict.get("alternatives", ())
            if (other["instead_of"], other["instead_of_axis"]) == (one["name"], one["axis"])
        ]
        for other in others:
            share = min(max(one["probability_of_class"] - own, 0.0) / len(others), 0.49)
            told[other] = max(told.get(other, 0.0), share)
    return told


def answer(case: Case, verdict: dict[str, Any], folder: Path) -> None:
    """Leave what a verdict says of a case."""
    told = told_by(verdict)
    torque = {axis: case.challenge.raw[f"{axis}.torque_model"].copy() for axis in case.axes}
    for equation in equations(case):
        names = [full for full in equation.candidates if said(full, equation.axis, verdict)]
        if names and equation.in_torque:
            first, second, challenge = (np.column_stack([equation.candidates[n][k] for n in names]) for k in range(3))
            matrix, lack = np.concatenate([first, second]), np.concatenate(equation.lack)
            torque[equation.axis] += challenge @ np.linalg.lstsq(matrix, lack, rcond=None)[0]
    write_answer(folder, told, torque, verdict.get("something_else"))


def main() -> None:
    """The command line: CASE ANSWER."""
    reader = argparse.ArgumentParser(description=__doc__)
    reader.add_argument("case", type=Path)
    reader.add_argument("answer", type=Path)
    chosen = reader.parse_args()
    case = read_case(chosen.case)
    chosen.answer.mkdir(parents=True, exist_ok=True)
    answer(case, verdict_of(case, chosen.answer), chosen.answer)


if __name__ == "__main__":
    main()
