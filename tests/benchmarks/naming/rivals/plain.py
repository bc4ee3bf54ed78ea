"""Plain parameter fitting: the numbers of the known model are fitted, and what moved most is what was wrong."""

from __future__ import annotations

import numpy as np

from tests.benchmarks.naming.rivals.answers import Equation, Found, run

#: what a model has numbers for
NUMBERS = ("viscous", "coulomb", "stribeck", "presliding", "inertia", "static_unbalance", "gyro_bias", "gyro_scale")


def by_fit(equation: Equation, knob: float) -> Found:
    """Least squares of all numbers; one is told whose column alone takes `knob` of the squares."""
    y = np.concatenate(equation.lack)
    names = [name for name in NUMBERS if name in equation.candidates]
    columns = [np.concatenate(equation.candidates[name][:2]) for name in names]
    matrix = np.column_stack(columns)
    weights = np.linalg.lstsq(matrix, y, rcond=None)[0]
    shares, at = {}, 0
    for name, part in zip(names, columns, strict=True):
        own = part @ weights[at : at + part.shape[1]]
        at += part.shape[1]
        shares[name] = 1.0 - float(np.sum((y - own) ** 2)) / float(np.sum(y**2))
    challenge = np.column_stack([equation.candidates[name][2] for name in names])
    return Found({name: min(share, 1.0) for name, share in shares.items() if share >= knob}, challenge @ weights)


if __name__ == "__main__":
    run(by_fit, knob=0.7)
