"""Friction that acts now: the model's table at the present temperature, and what a step wants of it, once a tick."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.friction import BUMP_GONE
from sim_backend.layout import (
    BUMP_GONE_SPEED,
    DELTA,
    IN_FORCE,
    IN_FORCE_SIZE,
    KNOT_SIZE,
    KNOTS,
    MAX_KNOTS,
    PER_VS,
    RELAXATION,
    SIGMA0,
    SIGMA1,
    SIGMA1_PER_STEP,
    SIGMA2,
    STEP_S,
    TC,
    TEMPERATURE_KNOTS,
    TS,
    VS,
)
from sim_backend.stribeck_expansion import has_bump_table

Friction = tuple[float, float, float, float, float, float, float, float, float, bool]


@compiled
def friction_in_force(P: np.ndarray, X: np.ndarray, axis: int) -> Friction:
    """Friction's numbers as a step wants them: Ts, Tc, sigma2, sigma0 h / Tc, 1 / vs, delta, the speed beyond which the
    bump is gone, sigma0, sigma1 / h, and whether the bump has a table.
    """
    f = IN_FORCE + axis * IN_FORCE_SIZE
    delta, tabled = X[f + DELTA], has_bump_table(P, axis, X[f + DELTA])
    relaxation, per_vs, gone, sigma1_per_step = (
        X[f + RELAXATION],
        X[f + PER_VS],
        X[f + BUMP_GONE_SPEED],
        X[f + SIGMA1_PER_STEP],
    )
    return X[f + TS], X[f + TC], X[f + SIGMA2], relaxation, per_vs, delta, gone, X[f + SIGMA0], sigma1_per_step, tabled


@compiled
def friction_at(P: np.ndarray, K: np.ndarray, axis: int, temperature: float, X: np.ndarray) -> None:
    """Put friction at a temperature (degC) in force: linear between the knots of the model's table, held beyond its
    ends.
    """
    first = KNOTS + axis * MAX_KNOTS * KNOT_SIZE
    last = first + (K[TEMPERATURE_KNOTS] - 1) * KNOT_SIZE
    knot = first
    while knot + KNOT_SIZE < last and P[knot + KNOT_SIZE] <= temperature:
        knot += KNOT_SIZE
    after = min(knot + KNOT_SIZE, last)
    width = P[after] - P[knot]
    share = min(1.0, max(0.0, (temperature - P[knot]) / width)) if width > 0.0 else 0.0
    for i in range(KNOT_SIZE - 1):
        X[IN_FORCE + axis * IN_FORCE_SIZE + i] = P[knot + 1 + i] + share * (P[after + 1 + i] - P[knot + 1 + i])
    derive_friction(X, axis, P[STEP_S])


@compiled
def derive_friction(X: np.ndarray, axis: int, h: float) -> None:
    """Put what steps of h seconds want of the friction in force behind it, so that they need not divide."""
    f = IN_FORCE + axis * IN_FORCE_SIZE
    # beyond this speed the power need not be computed
    X[f + BUMP_GONE_SPEED] = X[f + VS] * BUMP_GONE ** (1.0 / X[f + DELTA])
    X[f + PER_VS] = 1.0 / X[f + VS] if X[f + VS] > 0.0 else 0.0
    X[f + RELAXATION] = X[f + SIGMA0] * h / X[f + TC] if X[f + TC] > 0.0 else 0.0
    X[f + SIGMA1_PER_STEP] = X[f + SIGMA1] / h
