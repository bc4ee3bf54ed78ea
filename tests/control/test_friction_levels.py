"""Friction at the motor's temperature as the plant has it, and levels that follow what the loops add."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.loop.control import adapt_friction, friction_at, has_new_levels, layout, modelled_friction
from gimbal_hil.loop.host import layout as host
from gimbal_hil.loop.settings import host_configuration, with_changes
from gimbal_hil.pointing.arena import controller_settings
from sim_backend.friction import lugre_step, stribeck_level
from sim_backend.model import AntennaModel, model_from_document, shipped_model

STEP_S = 1e-3
#: about the outer axis, kg m^2
INERTIA = 0.5


def block(**changes: object) -> np.ndarray:
    """Parameters of the outer axis of `levels`, with changes."""
    settings = with_changes(
        controller_settings("levels"), {key.replace("__", "."): one for key, one in changes.items()}
    )
    return host_configuration(settings)[host.axis_c(0) : host.axis_c(0) + layout.CONTROL_PARAMETERS]


def warming() -> AntennaModel:
    """The realistic antenna, its outer friction a table over temperature."""
    model = shipped_model("realistic")
    rows = [(-40.0, 2.0), (20.0, 1.0), (85.0, 0.5)]
    names = {"breakaway": "N m", "coulomb": "N m", "viscous": "N m s/rad"}
    raw = model.document
    for axis in model.axes:
        friction = raw["axes"][axis]["friction"]
        plain = {key: model.number(axis, f"friction.{key}") for key in friction}
        friction["over_temperature"] = [
            {"temperature": at, **{key: value * (scale if key in names else 1.0) for key, value in plain.items()}}
            for at, scale in rows
        ]
    return model_from_document(raw, "warming")


@pytest.mark.heavy
@pytest.mark.parametrize(("temperature", "scale"), [(-60.0, 2.0), (-10.0, 1.5), (20.0, 1.0), (52.5, 0.75), (99.0, 0.5)])
def test_friction_is_read_from_the_models_table_at_the_motors_temperature(temperature: float, scale: float) -> None:
    model, settings = warming(), controller_settings("tuned")
    assert settings.model_control is not None
    kept = settings.model_control.model_copy(update={"document": model.document})
    C = host_configuration(settings.model_copy(update={"model_control": kept}))
    numbers = friction_at(temperature, C, host.axis_c(0))
    plain = shipped_model("realistic")
    assert numbers[0] == pytest.approx(scale * plain.number("outer", "friction.breakaway"))
    assert numbers[5] == pytest.approx(scale * plain.number("outer", "friction.viscous"))
    assert numbers[3] == plain.number("outer", "friction.sigma0")
    off = settings.model_copy(update={"model_control": kept.model_copy(update={"temperature": False})})
    cool = friction_at(temperature, host_configuration(off), host.axis_c(0))
    assert cool[0] == pytest.approx(plain.number("outer", "friction.breakaway"))


def test_viscosity_falls_with_temperature_as_the_effect_says() -> None:
    model = shipped_model("realistic").with_effect("temperature_viscosity", "outer", {"temperature_coefficient": 0.03})
    settings = controller_settings("tuned")
    assert settings.model_control is not None
    kept = settings.model_control.model_copy(update={"document": model.document})
    C = host_configuration(settings.model_copy(update={"model_control": kept}))
    viscous = model.number("outer", "friction.viscous")
    assert friction_at(-40.0, C, host.axis_c(0))[5] == pytest.approx(viscous * np.exp(1.8), rel=1e-9)
    assert friction_at(-40.0, C, host.axis_c(1))[5] == model.number("inner", "friction.viscous")


def follow(
    C: np.ndarray,
    sliding: float,
    viscous: float,
    weight: float = 0.0,
    minutes: float = 2.0,
    swing: tuple[float, float] = (0.8, 0.1),
    late_s: float = 0.0,
) -> np.ndarray:
    """State after swings of a joint whose friction has so many times the model's levels, with loops that add what
    lacks; the torque that accelerates is fed forward late.
    """
    H, bristle = np.zeros(layout.CONTROL_STATES), 0.0
    ts, tc, vs, sigma0, sigma1, sigma2, delta = friction_at(20.0, C, 0)
    for tick in range(round(60.0 * minutes / STEP_S)):
        (size, hertz), turn = swing, 2.0 * np.pi
        angle = turn * hertz * STEP_S * tick
        position, rate = size * np.sin(angle), size * turn * hertz * np.cos(angle)
        H[layout.SHAPED_POSITION], H[layout.SHAPED_RATE] = position, rate
        H[layout.SHAPED_ACCELERATION], H[layout.MOVED_INERTIA] = -position * (turn * hertz) ** 2, INERTIA
        before = -size * np.sin(angle - turn * hertz * late_s) * (turn * hertz) ** 2
        given = modelled_friction(rate, 20.0, STEP_S, H, 0, C, 0)
        level = sliding * stribeck_level(abs(rate), ts, tc, vs, delta)
        bristle, true = lugre_step(bristle, rate, STEP_S, level, sigma0, sigma1, viscous * sigma2)
        lacking = true + weight * np.cos(position + 0.3) + INERTIA * (H[layout.SHAPED_ACCELERATION] - before) - given
        adapt_friction(lacking, H, 0, C, 0)
    return H


def test_levels_come_to_what_the_joint_has_beside_a_weight_that_the_model_has_not() -> None:
    H = follow(block(), 1.3, 2.5, weight=0.4)
    assert 1.0 + H[layout.SLIDING_LEVEL] == pytest.approx(1.3, rel=0.01)
    assert 1.0 + H[layout.VISCOUS_LEVEL] == pytest.approx(2.5, rel=0.05)
    assert has_new_levels(H, 0)
    assert not has_new_levels(H, 0)


def test_levels_come_to_what_the_joint_has_in_small_reversals() -> None:
    H = follow(block(), 1.3, 1.0, weight=0.4, minutes=1.0, swing=(0.02, 0.2))
    assert 1.0 + H[layout.SLIDING_LEVEL] == pytest.approx(1.3, rel=0.01)


@pytest.mark.parametrize("late_s", [-0.006, 0.006])
def test_torque_that_accelerates_late_is_not_taken_for_viscosity_on_a_joint_that_swings_fast(late_s: float) -> None:
    H = follow(block(), 1.3, 1.0, minutes=0.5, swing=(0.014, 1.0), late_s=late_s)
    # six milliseconds at 1 Hz are twice the viscosity there is, one way or the other
    assert abs(H[layout.LEVEL_ESTIMATE]) > 1.5 and H[layout.VISCOUS_LEVEL] == 0.0
    assert 1.0 + H[layout.SLIDING_LEVEL] == pytest.approx(1.3, rel=0.1)
    # at 0.1 Hz they are a fiftieth
    slow = follow(block(), 1.0, 2.5, minutes=1.0, swing=(0.4, 0.1), late_s=late_s)
    assert 1.0 + slow[layout.VISCOUS_LEVEL] == pytest.approx(2.5, rel=0.1)


def test_nothing_changes_before_reversals_tell_an_interval() -> None:
    H = follow(block(), 1.3, 2.5, minutes=0.25)
    assert H[layout.LEVEL_REVERSALS] == 3.0
    assert H[layout.SLIDING_LEVEL] == H[layout.VISCOUS_LEVEL] == 0.0


def test_levels_keep_within_their_bounds() -> None:
    C = block(axes__outer__friction_levels={"least": 0.5, "largest": 1.2})
    H = follow(C, 3.0, 3.0, minutes=0.5)
    assert 1.0 + H[layout.SLIDING_LEVEL] == pytest.approx(1.2)
    H = follow(C, 0.1, 0.1, minutes=0.5)
    assert 1.0 + H[layout.SLIDING_LEVEL] == pytest.approx(0.5)


@pytest.mark.parametrize("state", ["off", "distrusted", "at the limit", "bristles bend"])
def test_nothing_is_taken_in_where_the_residual_says_nothing_of_friction(state: str) -> None:
    C = block(**({"axes__outer__friction_levels": None} if state == "off" else {}))
    H = np.zeros(layout.CONTROL_STATES)
    H[layout.SHAPED_RATE] = 0.5
    H[layout.SLIDING_PART] = 0.0 if state == "bristles bend" else 0.2
    H[layout.DISTRUST] = 0.5 if state == "distrusted" else 0.0
    H[layout.TORQUE] = C[layout.TORQUE_LIMIT] if state == "at the limit" else 0.0
    before = H.copy()
    adapt_friction(0.3, H, 0, C, 0)
    np.testing.assert_array_equal(H, before)
