"""A law of the model's own, carried along measured motion."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import entry_point
from sim_backend.effects import law_value
from sim_backend.layout import STEPS


@entry_point
def law_along(
    P: np.ndarray,
    o: int,
    X: np.ndarray,
    s: int,
    axis: int,
    motion: np.ndarray,
    torque: np.ndarray,
    heat: np.ndarray,
    out: np.ndarray,
) -> None:
    """What the law at P[o] answers in every interval of a `Record`, one step each, into out (n,)."""
    for k in range(len(out)):
        out[k] = law_value(P, o, X, s, motion[k, axis], motion[k, 2 + axis], torque[k, axis], heat[k, axis])
        X[STEPS] += 1.0
