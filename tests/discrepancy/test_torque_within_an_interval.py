"""Where in an interval a drive's torque acts counts: positions feel what comes early in it more."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy.hypotheses import Cause, Hypothesis, families, torque_residual
from gimbal_hil.knowledge.discrepancy.twin import Twin, record_of
from gimbal_hil.knowledge.improvement import budgets_of
from gimbal_hil.knowledge.improvement.motion import AxisMove, LapMotion, MotionSegment, experiment_of_motion
from gimbal_hil.knowledge.improvement.rehearsal import rehearse
from gimbal_hil.loop.settings import shipped_settings
from sim_backend.model import shipped_model

SETTINGS = shipped_settings()
BUDGETS = budgets_of(SETTINGS, 900.0, 3, {}, {})


@pytest.mark.parametrize(
    ("effect", "parameter", "milliseconds"),
    [("transport_delay", "delay", 0.5), ("transport_delay", "delay", 1.3), ("actuator_lag", "time_constant", 0.4)],
)
def test_a_delay_or_lag_of_a_part_of_a_sample_is_known_to_a_hundredth_at_the_end_of_the_band(
    effect: str, parameter: str, milliseconds: float
) -> None:
    """Means over the intervals alone miss 1.1 to 3.6 % of it, which is as much as tells the two apart."""
    swing = LapMotion((MotionSegment((AxisMove(None, 5e-4, 24.0), AxisMove()), 2.0),))
    antenna = shipped_model().with_effect(effect, "outer", {parameter: 1e-3 * milliseconds})
    table = rehearse(experiment_of_motion(swing, "", SETTINGS, BUDGETS), SETTINGS, antenna).table
    assert table is not None
    twin = Twin(shipped_model(), (record_of(table, shipped_model(), 25.0, "swing"),))
    family = next(one for one in families(twin, "outer") if one.effect == effect)
    floor = np.ones(len(twin.channels))
    right = Hypothesis((Cause(family, (milliseconds,)),))
    left, without = (torque_residual(twin, one, floor)[-80:, 0] for one in (right, Hypothesis()))
    assert np.sqrt(np.mean(left**2)) < 0.01 * np.sqrt(np.mean(without**2))
