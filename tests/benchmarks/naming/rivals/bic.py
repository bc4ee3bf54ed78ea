"""Regression over the catalogue, names added one after another while BIC falls: what a textbook would do."""

from __future__ import annotations

import numpy as np

from tests.benchmarks.naming.rivals.answers import Equation, Found, run


def by_bic(equation: Equation, knob: float) -> Found:
    """Forward selection. Rows count as independent once in `knob` rows: motion is no coin."""
    y = np.concatenate(equation.lack)
    columns = {name: np.concatenate(parts[:2]) for name, parts in equation.candidates.items()}
    count = len(y) / knob
    chosen: list[str] = []
    best = _bic(y, _matrix([], columns, len(y)), count)
    probability: dict[str, float] = {}
    while len(chosen) < 6:
        trials = {n: _bic(y, _matrix([*chosen, n], columns, len(y)), count) for n in columns if n not in chosen}
        name = min(trials, key=lambda n: trials[n])
        if trials[name] >= best:
            break
        # Schwarz: e^(-BIC/2) is in proportion to the probability of a model
        weights = {n: np.exp(-0.5 * (value - trials[name])) for n, value in trials.items()}
        without = np.exp(min(-0.5 * (best - trials[name]), 0.0))
        probability[name] = 1.0 / (sum(weights.values()) + without)
        best = trials[name]
        chosen.append(name)
    matrix = _matrix(chosen, columns, len(y))
    weights = np.linalg.lstsq(matrix, y, rcond=None)[0]
    challenge = {name: parts[2] for name, parts in equation.candidates.items()}
    length = len(next(iter(challenge.values())))
    return Found(probability, _matrix(chosen, challenge, length) @ weights)


def _matrix(names: list[str], columns: dict[str, np.ndarray], length: int) -> np.ndarray:
    return np.column_stack([columns[name] for name in names]) if names else np.zeros((length, 0))


def _bic(y: np.ndarray, matrix: np.ndarray, count: float) -> float:
    rest = y - matrix @ np.linalg.lstsq(matrix, y, rcond=None)[0] if matrix.shape[1] else y
    return count * float(np.log(np.mean(rest**2))) + matrix.shape[1] * float(np.log(count))


if __name__ == "__main__":
    run(by_bic, knob=400.0)
