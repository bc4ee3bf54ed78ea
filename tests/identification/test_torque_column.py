"""What a torque column may have been before it was logged."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from gimbal_hil.knowledge.identification import torque_column


def test_a_torque_that_every_median_fits_worse_was_not_filtered(monkeypatch: pytest.MonkeyPatch) -> None:
    motion = SimpleNamespace(torque=np.zeros(10))
    monkeypatch.setattr(torque_column, "step_of", lambda torque: 0.0)
    monkeypatch.setattr(torque_column, "_has_flat_extremes", lambda torque: True)
    monkeypatch.setattr(torque_column, "_before", lambda *given: (motion, SimpleNamespace(cost=1e6)))
    assert torque_column._before_medians(motion, (), SimpleNamespace(cost=1.0)) == []  # type: ignore[arg-type]


@pytest.mark.parametrize("rows", [2, 3, 5])
def test_a_torque_that_is_held_for_some_rows_was_not_behind_a_median(rows: int) -> None:
    rng = np.random.default_rng(rows)
    held = np.repeat(np.sin(0.05 * np.arange(600)) + 0.05 * rng.standard_normal(600), rows)
    assert torque_column._before_medians(SimpleNamespace(torque=held), (), SimpleNamespace(cost=1.0)) == []  # type: ignore[arg-type]


def test_a_smooth_torque_of_few_digits_rests_where_it_turns_back_and_was_not_filtered() -> None:
    smooth = np.round(np.sin(0.01 * np.arange(60_000)), 3)
    assert not torque_column._has_flat_extremes(smooth)
    noisy = np.random.default_rng(3).standard_normal(5000)
    from scipy.ndimage import median_filter

    assert torque_column._has_flat_extremes(median_filter(noisy, 9)) and not torque_column._has_flat_extremes(noisy)
