"""The cascade of one axis: torque limit, bumpless closing, base rate, prefilter, the thesis' form without
anti-windup.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gimbal_hil.loop.control import Mode, axis_torque, enter_mode
from gimbal_hil.loop.control.layout import (
    CONTROL_STATES,
    FILTERED,
    POSITION_INTEGRAL,
    RATE_INTEGRAL,
    TORQUE,
    TORQUE_LIMIT,
)
from gimbal_hil.loop.host import layout
from gimbal_hil.loop.settings import host_configuration, settings_from_document, shipped_settings

STEP_S = 1e-3
OUTER = layout.axis_c(0)
CLOSED = st.sampled_from([Mode.RATE, Mode.POSITION, Mode.INERTIAL_RATE])
NUMBERS = st.floats(-5.0, 5.0)


def configuration(**changes: object) -> np.ndarray:
    """C of the shipped antenna with changed keys of the outer axis, given as section__key."""
    document = shipped_settings().model_dump(mode="json", by_alias=True)
    for name, value in changes.items():
        section, _, key = name.partition("__")
        if key:
            document["axes"]["outer"][section][key] = value
        else:
            document["axes"]["outer"][section] = value
    return host_configuration(settings_from_document(document, "test"))


def torque(
    mode: Mode,
    reference: float,
    position: float,
    rate: float,
    H: np.ndarray,
    C: np.ndarray,
    slope: float = 0.0,
    base: float = 0.0,
) -> float:
    """One tick of the outer axis, its state at the start of H."""
    return axis_torque(int(mode), reference, slope, position, rate, base, 0.0, (-100.0, 100.0), STEP_S, H, 0, C, OUTER)


@given(CLOSED, st.lists(st.tuples(NUMBERS, NUMBERS, NUMBERS), min_size=1, max_size=30))
def test_torque_never_exceeds_its_limit(mode: Mode, ticks: list[tuple[float, float, float]]) -> None:
    C, H = configuration(), np.zeros(CONTROL_STATES)
    for reference, position, rate in ticks:
        assert abs(torque(mode, reference, position, rate, H, C)) <= C[OUTER + TORQUE_LIMIT]


@given(CLOSED, st.floats(-15.0, 15.0), NUMBERS, NUMBERS, st.floats(-1.0, 1.0))
def test_closing_a_loop_at_zero_error_goes_on_with_the_torque_of_the_last_tick(
    mode: Mode, before: float, position: float, rate: float, base: float
) -> None:
    C, H = configuration(), np.zeros(CONTROL_STATES)
    H[TORQUE] = before
    enter_mode(position, rate, base, 0.0, H, 0, C, OUTER)
    reference = {Mode.RATE: rate - base, Mode.POSITION: position, Mode.INERTIAL_RATE: rate}[mode]
    limit = C[layout.axis_c(0) + 4]
    if mode is not Mode.POSITION or abs(rate - base) < limit:
        assert torque(mode, reference, position, rate, H, C, base=base) == pytest.approx(before, abs=1e-9)


def test_the_base_rate_is_added_to_a_joint_rate_reference_and_not_to_an_inertial_one() -> None:
    C = configuration()
    assert torque(Mode.RATE, 0.1, 0.0, 0.4, np.zeros(CONTROL_STATES), C, base=0.3) == pytest.approx(0.0, abs=1e-12)
    held = torque(Mode.INERTIAL_RATE, 0.1, 0.0, 0.1, np.zeros(CONTROL_STATES), C, base=0.3)
    assert held == pytest.approx(0.0, abs=1e-12)
    apart = configuration(feedforward__base_rate=False)
    assert torque(Mode.RATE, 0.0, 0.0, 0.0, np.zeros(CONTROL_STATES), apart, base=0.3) == 0.0


def test_a_stuck_axis_winds_nothing_up() -> None:
    C, H = configuration(), np.zeros(CONTROL_STATES)
    for _ in range(20000):
        torque(Mode.POSITION, 1.0, 0.0, 0.0, H, C)
    limit = C[OUTER + TORQUE_LIMIT]
    assert abs(H[RATE_INTEGRAL]) <= limit
    assert abs(H[POSITION_INTEGRAL]) < 0.2


def test_without_anti_windup_a_stuck_axis_winds_up_as_in_the_thesis() -> None:
    C = configuration(rate_loop__anti_windup="none", position_loop__anti_windup="none")
    H = np.zeros(CONTROL_STATES)
    for _ in range(2000):
        torque(Mode.POSITION, 1.0, 0.0, 0.0, H, C)
    assert H[RATE_INTEGRAL] > 10 * C[OUTER + TORQUE_LIMIT]


def test_the_torque_scale_turns_controller_units_into_torque() -> None:
    C = configuration(rate_loop={"kp_s_per_rad": 2.0, "torque_per_unit_nm": 2.5})
    assert torque(Mode.RATE, 0.5, 0.0, 0.0, np.zeros(CONTROL_STATES), C) == pytest.approx(2.5)


def test_the_prefilter_answers_a_step_like_its_transfer_function() -> None:
    C = configuration(prefilter={"num": 4.72, "den": [1.3, 4.72]}, feedforward={"reference_rate": 0.0})
    H = np.zeros(CONTROL_STATES)
    for tick in range(1, 2001):
        torque(Mode.POSITION, 1.0, 0.0, 0.0, H, C)
        assert H[FILTERED] == pytest.approx(1.0 - math.exp(-4.72 / 1.3 * tick * STEP_S), abs=1e-9)


def test_with_its_slope_a_moving_reference_passes_the_prefilter_without_delay() -> None:
    C, H = configuration(), np.zeros(CONTROL_STATES)
    for tick in range(3000):
        torque(Mode.POSITION, 0.5 * tick * STEP_S, 0.0, 0.0, H, C, slope=0.5)
    assert H[FILTERED] == pytest.approx(0.5 * 2999 * STEP_S, abs=1e-3)


@given(st.floats(-6.0, 6.0), st.floats(0.5, 4.0), st.floats(2.0, 40.0), st.floats(2.0, 12.0))
def test_a_step_of_any_size_becomes_a_motion_within_its_limits(
    size: float, most_rad_s: float, most_rad_s2: float, corner: float
) -> None:
    limits = {"rate_rad_s": most_rad_s, "acceleration_rad_s2": most_rad_s2}
    C, H = configuration(prefilter={"num": corner, "den": [1.0, corner]} | limits), np.zeros(CONTROL_STATES)
    # to full speed and back at most, then what the filter itself takes
    seconds = abs(size) / most_rad_s + 2.0 * most_rad_s / most_rad_s2 + 12.0 / corner
    outputs = []
    for _ in range(int(seconds / STEP_S)):
        torque(Mode.POSITION, size, 0.0, 0.0, H, C)
        outputs.append(H[FILTERED])
    speed = np.diff([0.0, *outputs]) / STEP_S
    assert np.abs(speed).max() <= most_rad_s * (1.0 + 1e-9)
    assert np.abs(np.diff([0.0, *speed])).max() / STEP_S <= most_rad_s2 * (1.0 + 1e-6)
    assert outputs[-1] == pytest.approx(size, abs=1e-3 * abs(size) + 1e-9)
    assert np.abs(outputs).max() <= abs(size) * (1.0 + 1e-3) + 1e-9


@given(st.lists(st.tuples(CLOSED, NUMBERS, NUMBERS, NUMBERS, NUMBERS), min_size=1, max_size=20))
def test_compiled_and_interpreted_cascade_give_the_same_bits(
    ticks: list[tuple[Mode, float, float, float, float]],
) -> None:
    C = configuration()
    plain = getattr(axis_torque, "py_func", axis_torque)
    one, other = np.zeros(CONTROL_STATES), np.zeros(CONTROL_STATES)
    for mode, reference, slope, position, rate in ticks:
        numbers = (int(mode), reference, slope, position, rate, 0.1, 0.2, (-2.0, 3.0), STEP_S)
        assert axis_torque(*numbers, one, 0, C, OUTER) == plain(*numbers, other, 0, C, OUTER)
    assert one.tobytes() == other.tobytes()
