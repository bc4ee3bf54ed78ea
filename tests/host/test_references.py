"""Reference shapes: value and slope belong together, moves arrive, tables and pulses are what they say."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gimbal_hil.loop.host import Shape
from gimbal_hil.loop.host.references import reference_at

VALUES, POSITIVE, TIMES = st.floats(-3.0, 3.0), st.floats(0.05, 5.0), st.floats(0.0, 6.0)


def at(
    shape: Shape, parameters: tuple[float, ...], time_s: float, start: float = 0.0, origin: float = 0.0
) -> tuple[float, float]:
    """Value and slope."""
    return reference_at(int(shape), np.array(parameters, dtype=np.float64), 0, origin, start, time_s)


SMOOTH_SHAPES = st.one_of(
    st.tuples(st.just(Shape.HOLD), st.tuples(VALUES)),
    st.tuples(st.just(Shape.SINE), st.tuples(VALUES, VALUES, POSITIVE, VALUES)),
    st.tuples(st.just(Shape.CHIRP), st.tuples(VALUES, VALUES, POSITIVE, st.floats(-0.5, 0.5), st.just(10.0))),
    st.tuples(st.just(Shape.TRAPEZOID), st.tuples(VALUES, POSITIVE, POSITIVE)),
    st.tuples(st.just(Shape.SMOOTH), st.tuples(VALUES, POSITIVE)),
)


@given(SMOOTH_SHAPES, TIMES, VALUES, VALUES)
def test_the_slope_is_the_derivative_of_the_value(
    shape: tuple[Shape, tuple[float, ...]], time_s: float, start: float, origin: float
) -> None:
    h = 1e-5
    before, after = (at(shape[0], shape[1], t, start, origin)[0] for t in (time_s, time_s + 2 * h))
    slope = at(shape[0], shape[1], time_s + h, start, origin)[1]
    assert (after - before) / (2 * h) == pytest.approx(slope, abs=2e-2, rel=2e-3)


@given(VALUES, VALUES, POSITIVE, POSITIVE)
def test_a_trapezoid_goes_from_start_to_target_within_its_limits(
    start: float, target: float, top: float, curvature: float
) -> None:
    total = abs(target - start) / top + top / curvature + 10.0
    times = np.linspace(0.0, total, 400)
    values, slopes = np.array([at(Shape.TRAPEZOID, (target, top, curvature), t, start) for t in times]).T
    assert values[0] == pytest.approx(start)
    assert values[-1] == target and slopes[-1] == 0.0
    assert np.max(np.abs(slopes)) <= top * (1 + 1e-12)
    assert np.max(np.abs(np.diff(slopes))) <= curvature * times[1] * (1 + 1e-6) + 1e-12
    assert np.all(np.diff(values) * (target - start) >= -1e-12)


def test_a_ramp_ends_after_its_span() -> None:
    assert at(Shape.RAMP, (0.5, -0.1, 0.2), 1.0) == (pytest.approx(0.4), -0.1)
    assert at(Shape.RAMP, (0.5, -0.1, 0.2), 5.0) == (pytest.approx(0.3), 0.0)
    assert at(Shape.RAMP, (0.5, 0.1, math.inf), 50.0)[0] == pytest.approx(5.5)
    assert at(Shape.RAMP, (0.5, 0.0, math.inf), 50.0) == (0.5, 0.0)


def test_pulses_begin_on_their_tick_and_alternate() -> None:
    values = [at(Shape.PULSES, (1.0, 0.5, 0.01, 0.003, 1.0, 3.0), k * 1e-3)[0] for k in range(50)]
    expected = np.ones(50)
    expected[0:3], expected[10:13], expected[20:23] = 1.5, 0.5, 1.5
    assert values == expected.tolist()


def test_a_table_joins_its_rows_and_holds_the_last_one() -> None:
    plan = np.array([4.0, 3.0, 0.5, 2.0, 1.0, 2.0, -1.0])
    values = [reference_at(int(Shape.TABLE), plan, 0, 10.0, 0.0, t)[0] for t in (0.0, 0.25, 0.5, 0.75, 1.0, 9.0)]
    assert values == pytest.approx([12.0, 13.0, 14.0, 11.0, 8.0, 8.0])


def test_a_start_value_moves_values_and_targets() -> None:
    assert at(Shape.SINE, (0.1, 0.0, 1.0, 0.0), 0.3, origin=2.0)[0] == pytest.approx(2.1)
    assert at(Shape.SMOOTH, (0.5, 1.0), 2.0, start=2.0, origin=2.0) == (2.5, 0.0)
