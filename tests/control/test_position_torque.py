"""Torque over position: the model's own effects, and a table that takes what the loops add."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gimbal_hil.loop.control import bin_of, layout, learn, learned_torque, named_torque
from gimbal_hil.loop.host import layout as host
from gimbal_hil.loop.settings import host_configuration, with_changes
from gimbal_hil.pointing.arena import controller_settings
from sim_backend.model import shipped_model

STEP_S = 1e-3


def block(learned: dict[str, object] | None = None) -> np.ndarray:
    settings = with_changes(controller_settings("learned"), {"axes.outer.learned": learned or {}})
    return host_configuration(settings)[host.axis_c(0) : host.axis_c(0) + layout.CONTROL_PARAMETERS]


def test_the_torque_that_the_model_names_is_against_its_cogging_cable_and_offset() -> None:
    spring = {"stiffness": 0.4, "rest_position": 0.1}
    model = shipped_model("realistic").with_effect("cable_spring", "outer", spring)
    model = model.with_effect("torque_offset", "outer", {"offset": 0.05})
    settings = controller_settings("tuned")
    assert settings.model_control is not None
    kept = settings.model_control.model_copy(update={"document": model.document})
    C = host_configuration(settings.model_copy(update={"model_control": kept}))
    for q in (-2.0, 0.0, 0.3, 7.0):
        acts = 0.08 * math.sin(36 * q + 0.4) - 0.4 * (q - 0.1) + 0.05
        assert named_torque(q, C, host.axis_c(0)) == pytest.approx(-acts, abs=1e-12)


def test_bins_go_round_the_turn() -> None:
    width = 2.0 * math.pi / layout.LEARNED_BINS
    assert bin_of(0.0)[:2] == (0, 1)
    assert bin_of(-0.5 * width) == pytest.approx((719, 0, 0.5))
    assert bin_of(2.0 * math.pi + 2.25 * width) == pytest.approx((2, 3, 0.25))


def lacking(position: float, rate: float) -> float:
    """What a joint needs beyond what is fed forward: a ripple, and friction that differs by direction."""
    return 0.1 * math.sin(20.0 * position) + (0.05 if rate > 0.0 else -0.02)


def swing(C: np.ndarray, H: np.ndarray, swings: int) -> float:
    """Rms of what still lacks over the last swing."""
    left = []
    for tick in range(round(swings * 10.0 / STEP_S)):
        angle = 2.0 * math.pi * 0.1 * tick * STEP_S
        position, rate = 0.3 * math.sin(angle), 0.3 * 2.0 * math.pi * 0.1 * math.cos(angle)
        H[layout.SHAPED_POSITION], H[layout.SHAPED_RATE] = position, rate
        ahead = position + C[layout.DELAY_TICKS] * STEP_S * rate
        missing = lacking(position, rate) - learned_torque(ahead, rate, H, 0, C, 0)
        learn(missing, STEP_S, H, 0, C, 0)
        left.append(missing)
    return float(np.sqrt(np.mean(np.square(left[-10000:]))))


def test_what_lacks_falls_to_a_tenth_in_a_dozen_swings_and_stays_when_frozen() -> None:
    C, H = block(), np.zeros(layout.CONTROL_STATES)
    first = swing(C, H, 1)
    assert swing(C, H, 12) < 0.1 * first
    C[layout.LEARN_SHARE] = 0.0
    kept = H[layout.LEARNED_TABLE :].copy()
    assert swing(C, H, 1) < 0.1 * first
    np.testing.assert_array_equal(H[layout.LEARNED_TABLE :], kept)


def test_no_entry_leaves_its_bound_nor_comes_from_beyond_it() -> None:
    C, H = block({"largest_nm": 0.03, "entries": [(3, 1.0, -1.0)]}), np.zeros(layout.CONTROL_STATES)
    assert learned_torque(3 * 2.0 * math.pi / layout.LEARNED_BINS, 0.1, H, 0, C, 0) == pytest.approx(0.03)
    swing(C, H, 6)
    table = H[layout.LEARNED_TABLE :] + C[layout.GIVEN_TABLE : layout.GIVEN_TABLE + 2 * layout.LEARNED_BINS]
    assert np.abs(table).max() == pytest.approx(0.03)


@pytest.mark.parametrize("state", ["distrusted", "at the limit", "at rest", "too fast"])
def test_nothing_is_learned_where_the_residual_is_no_torque_over_position(state: str) -> None:
    C, H = block(), np.zeros(layout.CONTROL_STATES)
    H[layout.SHAPED_RATE] = {"at rest": 0.0, "too fast": 0.6}.get(state, 0.1)
    H[layout.DISTRUST] = 0.5 if state == "distrusted" else 0.0
    H[layout.TORQUE] = C[layout.TORQUE_LIMIT] if state == "at the limit" else 0.0
    learn(0.3, STEP_S, H, 0, C, 0)
    assert not H[layout.LEARNED_TABLE :].any()
