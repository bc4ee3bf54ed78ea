"""pyoperon: a formula by symbolic regression with fitted constants, named by the candidate that repeats it."""

from __future__ import annotations

import numpy as np
from pyoperon.sklearn import SymbolicRegressor

from tests.benchmarks.naming.rivals.answers import Equation, Found, name_of, run


def by_operon(equation: Equation, knob: float) -> Found:
    """Defaults of its scikit-learn face, formulas of 25 nodes at most; `knob` of the squares is to be repeated."""
    x, y = np.concatenate(equation.variables[:2]), np.concatenate(equation.lack)
    size, scale = x.std(axis=0) + 1e-30, float(y.std()) + 1e-30
    search = SymbolicRegressor(
        allowed_symbols="add,sub,mul,abs,sin,cos,tanh,constant,variable", max_length=25, max_evaluations=100_000,
        n_threads=1, random_state=0, optimizer_iterations=3,
    )  # fmt: skip
    search.fit(x / size, y / scale)
    predicted = [np.ravel(search.predict(part / size)) * scale for part in equation.variables]
    return Found(name_of(equation, predicted[1], knob), predicted[2])


if __name__ == "__main__":
    run(by_operon, knob=0.99)
