"""sysidentpy: forward regression orthogonal least squares over polynomials of the motion, terms counted by BIC."""

from __future__ import annotations

import numpy as np
from sysidentpy.basis_function import Polynomial
from sysidentpy.model_structure_selection import FROLS

from tests.benchmarks.naming.rivals.answers import Equation, Found, name_of, run


def by_frols(equation: Equation, knob: float) -> Found:
    """A NFIR model of degree two with one lag; its prediction is named by the candidate that repeats `knob` of it."""
    x, y = np.concatenate(equation.variables[:2]), np.concatenate(equation.lack)[:, None]
    size, scale = x.std(axis=0) + 1e-30, float(y.std()) + 1e-30
    model = FROLS(
        order_selection=True, n_info_values=12, info_criteria="bic", xlag=[[1]] * x.shape[1], ylag=1,
        model_type="NFIR", basis_function=Polynomial(degree=2),
    )  # fmt: skip
    # its inputs act one row later; what is asked for here acts at once
    model.fit(X=np.roll(x / size, -1, axis=0), y=y / scale)

    def predicted(log: int) -> np.ndarray:
        inputs = np.roll(equation.variables[log] / size, -1, axis=0)
        return np.ravel(model.predict(X=inputs, y=np.zeros((len(inputs), 1)))) * scale

    return Found(name_of(equation, predicted(1), knob), predicted(2))


if __name__ == "__main__":
    run(by_frols, knob=0.97)
