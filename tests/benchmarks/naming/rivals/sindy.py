"""pysindy's ensembles over the catalogue's columns: how often a column is chosen in bootstraps is its probability."""

from __future__ import annotations

import numpy as np
import pysindy

from tests.benchmarks.naming.rivals.answers import Equation, Found, run

MODELS = 30


def by_ensemble(equation: Equation, knob: float) -> Found:
    """Sequentially thresholded least squares on columns of unit size, bagged; `knob` is the threshold, in shares of
    the lack.
    """
    y = np.concatenate(equation.lack)
    names = [name for name, parts in equation.candidates.items() for _ in range(parts[0].shape[1])]
    matrix = np.column_stack([np.concatenate(parts[:2]) for parts in equation.candidates.values()])
    size = np.sqrt(np.mean(matrix**2, axis=0)) + 1e-30
    scale = float(np.sqrt(np.mean(y**2)))
    base = pysindy.STLSQ(threshold=knob, alpha=0.05)
    ensemble = pysindy.EnsembleOptimizer(opt=base, bagging=True, n_models=MODELS)
    ensemble.fit(matrix / size, (y / scale)[:, None])
    all_weights = np.stack([np.ravel(weights) for weights in ensemble.coef_list])
    chosen = np.mean(np.abs(all_weights) > 1e-12, axis=0)
    probability: dict[str, float] = {}
    for name, share in zip(names, chosen, strict=True):
        probability[name] = max(probability.get(name, 0.0), float(share))
    weights = np.median(all_weights, axis=0)
    challenge = np.column_stack([parts[2] for parts in equation.candidates.values()])
    return Found({n: p for n, p in probability.items() if p >= 0.1}, (challenge / size) @ weights * scale)


if __name__ == "__main__":
    np.random.seed(0)
    run(by_ensemble, knob=0.8)
