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
