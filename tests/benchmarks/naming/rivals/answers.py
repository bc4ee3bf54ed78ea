"""How every rival of regression takes part: equations in, names and a prediction out."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.benchmarks.naming.rivals.columns import Case, rate_columns, read_case, torque_columns
from tests.benchmarks.naming.tables import write_csv

Array = np.ndarray
#: rows of a fit: a log has many more than it says new things
EVERY = 40


@dataclass(frozen=True)
class Equation:
    """One thing to be explained: a column of what the model lacks, candidates by name, and variables for those that
    make their own terms. `first` and `second` are the two measured logs, thinned; `challenge` is whole.
    """

    axis: str
    in_torque: bool
    #: (first, second)
    lack: tuple[Array, Array]
    #: by name: (first, second, challenge), (n, columns) each
    candidates: dict[str, tuple[Array, Array, Array]]
    #: position, rate, acceleration, torque, sign of the rate: (first, second, challenge)
    variables: tuple[Array, Array, Array]


@dataclass(frozen=True)
class Found:
    """What a rival says of one equation: probability by name, and its prediction on the challenge (n,)."""

    names: dict[str, float]
    predicted: Array


Method = Callable[[Equation, float], Found]


def equations(case: Case) -> list[Equation]:
    """Torque of every axis, then rate error of every axis where there is a gyro."""
    found = []
    first, second = case.measured
    edge = len(first.rate) // 20
    kept = slice(edge, -edge, EVERY)
    for k, axis in enumerate(case.axes):
        columns = [torque_columns(case, log, k) for log in (first, second, case.challenge)]
        assert first.lack is not None and second.lack is not None
        found.append(_equation(axis, True, (first.lack[kept, k], second.lack[kept, k]), columns, kept))
        if first.rate_error is not None and second.rate_error is not None:
            columns = [rate_columns(case, log, k) for log in (first, second, case.challenge)]
            lacks = first.rate_error[kept, k], second.rate_error[kept, k]
            found.append(_equation(axis, False, lacks, columns, kept))
    return found


def _equation(
    axis: str, in_torque: bool, lack: tuple[Array, Array], columns: list[dict[str, list[Array]]], kept: slice
) -> Equation:
    names = [name for name in columns[0] if all(name in each for each in columns)]
    stacked = {
        name: (
            np.stack(columns[0][name], axis=1)[kept],
            np.stack(columns[1][name], axis=1)[kept],
            np.stack(columns[2][name], axis=1),
        )
        for name in names
    }
    wanted = ("cable_spring", "viscous", "inertia", "coulomb") if in_torque else tuple(names)
    variables = tuple(np.concatenate([stacked[name][log][:, :1] for name in wanted], axis=1) for log in range(3))
    return Equation(axis, in_torque, lack, stacked, variables)  # type: ignore[arg-type]


def asked(knob: float) -> argparse.Namespace:
    """The command line of an adapter: CASE ANSWER [--knob X]."""
    reader = argparse.ArgumentParser()
    reader.add_argument("case", type=Path)
    reader.add_argument("answer", type=Path)
    reader.add_argument("--knob", type=float, default=knob)
    return reader.parse_args()


def run(method: Method, knob: float) -> None:
    """Answer as the command line asks, equation by equation."""
    chosen = asked(knob)
    case = read_case(chosen.case)
    told: dict[tuple[str, str], float] = {}
    torque = {axis: case.challenge.raw[f"{axis}.torque_model"].copy() for axis in case.axes}
    for equation in equations(case):
        found = method(equation, chosen.knob)
        for name, probability in found.names.items():
            pair = (name.split("#")[0], equation.axis)
            told[pair] = max(told.get(pair, 0.0), float(probability))
        if equation.in_torque:
            torque[equation.axis] += found.predicted
    write_answer(chosen.answer, told, torque)


def write_answer(
    folder: Path, told: dict[tuple[str, str], float], torque: dict[str, Array], none: float | None = None
) -> None:
    """Probability by name and axis, and torque on the challenge by axis. `none` is the probability that all names are
    wrong; without it that of names that are independent.
    """
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(folder / "torque.csv", {f"{axis}.torque": column for axis, column in torque.items()})
    effects = [{"name": name, "axis": axis, "probability": p} for (name, axis), p in told.items()]
    if none is None:
        none = float(np.prod([1.0 - p for p in told.values()]))
    (folder / "answer.json").write_text(json.dumps({"effects": effects, "something_else": none}, indent=1))


def name_of(equation: Equation, predicted: Array, least: float) -> dict[str, float]:
    """Names for a formula that has none: that of the candidate which repeats its prediction on the second log best, if
    it repeats `least` of its squares.
    """
    total = float(np.sum((predicted - predicted.mean()) ** 2))
    lack = equation.lack[1]
    if total < 0.1 * float(np.sum((lack - lack.mean()) ** 2)):
        return {}
    shares = {}
    for name, (_, columns, _) in equation.candidates.items():
        matrix = np.column_stack([columns, np.ones(len(columns))])
        rest = predicted - matrix @ np.linalg.lstsq(matrix, predicted, rcond=None)[0]
        shares[name] = 1.0 - float(np.sum(rest**2)) / total
    best = max(shares, key=lambda name: shares[name])
    return {best: shares[best]} if shares[best] >= least else {}
