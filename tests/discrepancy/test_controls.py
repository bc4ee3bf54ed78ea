"""A negative control takes what chance takes: nothing of what the cause itself explains, and as much of the rest."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy.search.screening import control_gain

ROWS = 400


def ripple(order: float) -> np.ndarray:
    """Sine and cosine of a ripple in a turn and a half at a speed that changes by three fifths, (rows, 2)."""
    t = np.linspace(0.0, 1.0, ROWS)
    angle = 3.0 * np.pi * (t + 0.6 * np.sin(2.0 * np.pi * t) / (2.0 * np.pi))
    return np.column_stack([np.sin(order * angle), np.cos(order * angle)])


def control(columns: np.ndarray, residual: np.ndarray, block: int = 0) -> float:
    """Share of a residual that the best control takes."""
    nothing = np.zeros((ROWS, 0))
    return control_gain(columns, residual, nothing, [ROWS], 1, block, seed=3) / float(residual @ residual)


@pytest.mark.parametrize(("columns", "block"), [(ripple(7.0), 0), (np.abs(ripple(0.7)[:, :1]), 40)])
def test_a_control_takes_nothing_of_what_the_cause_explains_alone(columns: np.ndarray, block: int) -> None:
    assert control(columns, columns @ np.ones(columns.shape[1]), block) < 1e-12


@pytest.mark.parametrize(("columns", "block"), [(ripple(7.0), 0), (np.abs(ripple(0.7)[:, :1]), 40)])
def test_a_control_takes_of_noise_what_the_best_of_forty_takes_by_chance(columns: np.ndarray, block: int) -> None:
    noise = np.random.default_rng(5).standard_normal((20, ROWS))
    shares = [control(columns, one, block) for one in noise]
    # of n rows a column takes 1/n; the best of forty some four to eight times as much
    assert 2.0 / ROWS < np.mean(shares) < 16.0 / ROWS


def test_a_control_takes_nothing_of_the_cause_beside_what_is_there_either() -> None:
    # mostly an offset, which the hypothesis has already
    columns = 5.0 + np.abs(ripple(0.7)[:, :1])
    basis = np.full((ROWS, 1), 1.0 / np.sqrt(ROWS))
    new = columns[:, 0] - columns.mean()
    assert control_gain(columns, new, basis, [ROWS], 1, 40, seed=3) < 1e-12 * float(new @ new)
