"""The PI law: limits, anti-windup, and the same bits compiled and interpreted."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gimbal_hil.loop.control import AntiWindup, clamp, next_integral

ERRORS = st.floats(-10.0, 10.0)
GAINS = st.floats(0.0, 500.0)


def interpreted(function: Callable[..., object]) -> Callable[..., object]:
    """The Python form of a compiled function."""
    return getattr(function, "py_func", function)


@given(st.floats(allow_infinity=True, allow_nan=False), st.floats(0.0, 20.0))
def test_clamp_stays_within_its_limits(value: float, limit: float) -> None:
    assert -limit <= clamp(value, -limit, limit) <= limit


def test_clamp_lets_nan_through_to_the_last_check() -> None:
    assert math.isnan(clamp(math.nan, -1.0, 1.0))


@given(ERRORS, st.floats(-5.0, 5.0), GAINS, GAINS)
def test_clamping_keeps_the_integral_within_the_limits(error: float, integral: float, kp: float, ki: float) -> None:
    after = next_integral(error, integral, kp, ki, 1e-3, -5.0, 5.0, int(AntiWindup.CLAMPING), 0.1)
    assert -5.0 <= after <= 5.0


@given(ERRORS, st.floats(-5.0, 5.0), GAINS, GAINS)
def test_clamping_never_pushes_further_into_the_limit(error: float, integral: float, kp: float, ki: float) -> None:
    after = next_integral(error, integral, kp, ki, 1e-3, -5.0, 5.0, int(AntiWindup.CLAMPING), 0.1)
    if kp * error + integral > 5.0:
        assert after <= integral
    if kp * error + integral < -5.0:
        assert after >= integral


@given(st.sampled_from(list(AntiWindup)), ERRORS, st.floats(-1.0, 1.0))
def test_within_the_limits_all_kinds_integrate_alike(kind: AntiWindup, error: float, integral: float) -> None:
    after = next_integral(error, integral, 1.0, 3.0, 1e-3, -100.0, 100.0, int(kind), 0.1)
    assert after == integral + 3.0 * 1e-3 * error


def test_without_anti_windup_the_integral_grows_without_bound() -> None:
    integral = 0.0
    for _ in range(10000):
        integral = next_integral(1.0, integral, 0.0, 10.0, 1e-3, -1.0, 1.0, int(AntiWindup.NONE), 0.1)
    assert abs(integral - 100.0) < 1e-6


def test_back_calculation_brings_a_wound_up_integral_back_with_its_time_constant() -> None:
    integral = 50.0
    for _ in range(500):
        integral = next_integral(0.0, integral, 0.0, 10.0, 1e-3, -1.0, 1.0, int(AntiWindup.BACK_CALCULATION), 0.1)
    assert abs((integral - 1.0) / 49.0 - math.exp(-5.0)) < 0.01


@given(st.sampled_from(list(AntiWindup)), ERRORS, st.floats(-20.0, 20.0), GAINS, GAINS, st.floats(0.1, 10.0))
def test_compiled_and_interpreted_law_give_the_same_bits(
    kind: AntiWindup, error: float, integral: float, kp: float, ki: float, limit: float
) -> None:
    given_numbers = (error, integral, kp, ki, 1e-3, -limit, limit, int(kind), 0.05)
    compiled, plain = next_integral(*given_numbers), interpreted(next_integral)(*given_numbers)
    assert np.float64(compiled).tobytes() == np.float64(plain).tobytes()
