"""A linear law in place of the host's loops: the cascade as one is the cascade."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.knowledge.tuning import SampledLaw, as_array
from gimbal_hil.knowledge.tuning.rivals import _cascade
from gimbal_hil.loop.settings import DaemonSettings, with_changes
from gimbal_hil.pointing.arena import Trial, chosen, controller_settings, run_trial, shipped_scenarios
from gimbal_hil.pointing.arena.wrong_numbers import with_wrong_law
from sim_backend.model import shipped_model

pytestmark = pytest.mark.heavy
MODEL = shipped_model("realistic")


def as_law(settings: DaemonSettings) -> np.ndarray:
    """The cascade of a configuration as two sampled laws."""
    laws = []
    for axis in settings.axes.values():
        position, rate = axis.position_loop, axis.rate_loop
        gains = position.kp_per_s, position.ki_per_s2, rate.kp_s_per_rad, rate.ki_per_rad
        laws.append(SampledLaw(settings.step_s, *_cascade(settings.step_s, *gains)))
    return as_array(laws)


def without_gains(settings: DaemonSettings) -> DaemonSettings:
    keys = ("position_loop.kp_per_s", "position_loop.ki_per_s2", "rate_loop.kp_s_per_rad", "rate_loop.ki_per_rad")
    changes = {f"axes.{axis}.{key}": 0.0 for axis in settings.axes for key in keys}
    return with_changes(settings, changes | {"model_control.watch": False})


@pytest.mark.parametrize("name", ["bodies", "all_without_observer"])
def test_the_cascade_as_a_law_points_as_the_cascade(name: str) -> None:
    settings = controller_settings("bodies")
    if name != "bodies":
        parts = ("friction", "position_torque", "extrapolate_base")
        settings = with_changes(settings, {f"model_control.{part}": True for part in parts})
    scenario = chosen(shipped_scenarios(), "0.02 rad at 0.2 Hz")[0].model_copy(update={"duration_s": 8.0})
    own = run_trial(Trial(scenario, "own", settings, "realistic", MODEL, 1))
    law = run_trial(Trial(scenario, "law", without_gains(settings), "realistic", MODEL, 1, law=as_law(settings)))
    assert not own.tripped and not law.tripped
    assert law.los_rms == pytest.approx(own.los_rms, rel=0.05)
    assert law.reversal_peak == pytest.approx(own.reversal_peak, rel=0.1)


def test_a_law_of_a_wrong_model_asks_for_torques_as_wrong_as_its_inertias() -> None:
    settings = controller_settings("bodies")
    law = as_law(settings)
    wrong = with_wrong_law(law, settings, 0.3, 1)
    np.testing.assert_allclose(wrong[:, -1], 1.3 * law[:, -1])
    np.testing.assert_array_equal(wrong[:, :-1], law[:, :-1])
    assert with_wrong_law(law, settings, 0.0, 1) is law
