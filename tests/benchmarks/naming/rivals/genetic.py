"""gplearn: a formula by genetic programming, named by the candidate that repeats it."""

from __future__ import annotations

import numpy as np
from gplearn.genetic import SymbolicRegressor

from tests.benchmarks.naming.rivals.answers import Equation, Found, name_of, run


def by_genes(equation: Equation, knob: float) -> Found:
    """Settings of its documentation's example with a tenth of its population and half of its generations (time);
    `knob` of the squares has to be repeated by a name.
    """
    x, y = np.concatenate(equation.variables[:2]), np.concatenate(equation.lack)
    size, scale = x.std(axis=0) + 1e-30, float(y.std()) + 1e-30
    search = SymbolicRegressor(
        population_size=500, generations=10, p_crossover=0.7, p_subtree_mutation=0.1, p_hoist_mutation=0.05,
        p_point_mutation=0.1, max_samples=0.9, parsimony_coefficient=0.01, random_state=0,
        function_set=("add", "sub", "mul", "abs", "sin", "cos"),
    )  # fmt: skip
    search.fit(x / size, y / scale)
    predicted = [np.asarray(search.predict(part / size)) * scale for part in equation.variables]
    return Found(name_of(equation, predicted[1], knob), predicted[2])


if __name__ == "__main__":
    run(by_genes, knob=0.99)
