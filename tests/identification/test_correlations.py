"""The correlations of numbers, as a matrix and as a sentence."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gimbal_hil.knowledge.identification import RigidAxisRule, fit_rigid_axis
from gimbal_hil.knowledge.identification.correlations import Correlations, of_all_axes, of_fit, of_replicates
from gimbal_hil.knowledge.identification.least_squares import Unknown, fit


def pair(r: float, relative: tuple[float, float] = (0.1, 0.1)) -> Correlations:
    return Correlations(("viscous", "coulomb"), np.array([[1.0, r], [r, 1.0]]), np.array(relative))


def test_a_pair_that_cannot_be_told_apart_is_said_with_what_is_known_of_it() -> None:
    # 1.96 sqrt(2 (1 -+ 0.98)) over 1/0.2 + 1/0.2
    text = pair(-0.98, (0.2, 0.2)).worst("elevation")
    assert text.startswith("viscous and coulomb of elevation cannot be told apart (correlation -0.980)")
    assert "a weighted sum of them is known to 3.9 %, how it divides between them to 39 % only" in text
    other = pair(0.98, (0.2, 0.2)).worst("elevation")
    assert "a weighted difference of them is known to 3.9 %, how large both are to 39 % only" in other


def test_a_pair_that_is_known_although_it_hangs_together_is_not_called_unknown() -> None:
    assert "known nonetheless" in pair(-0.98, (0.001, 0.001)).worst("elevation")


def test_of_pairs_that_hang_together_the_one_that_is_known_worst_is_told() -> None:
    matrix = np.array([[1.0, -0.99, 0.0, 0.0], [-0.99, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.92], [0.0, 0.0, 0.92, 1.0]])
    found = Correlations(("breakaway", "shape", "viscous", "late"), matrix, np.array([1e-3, 1e-3, 0.3, 0.3]))
    assert found.worst("arm").startswith("viscous and late of arm cannot be told apart")


def test_numbers_that_are_known_by_themselves_are_said_to_be() -> None:
    assert "are told apart" in pair(0.3).worst("elevation") and "0.30" in pair(0.3).worst("elevation")
    assert pair(0.0).condition == pytest.approx(1.0)
    assert pair(-0.98).condition == pytest.approx(1.98 / 0.02)


def test_no_number_and_one_have_no_pair() -> None:
    none = Correlations((), np.eye(0), np.zeros(0)).as_record("outer")
    assert none["matrix"] == [] and none["condition"] == 1.0
    alone = Correlations(("sigma0",), np.eye(1), np.array([0.1]))
    assert alone.worst("outer") == "" and alone.as_record("outer")["worst"] == {"names": [], "text": ""}


@given(st.floats(-0.99, 0.99), st.floats(0.01, 100.0), st.integers(0, 2**32 - 1))
def test_replicates_give_the_correlation_that_they_were_drawn_with_whatever_the_units(
    r: float, unit: float, seed: int
) -> None:
    drawn = np.random.default_rng(seed).multivariate_normal([2.0, 3.0], [[0.01, 0.01 * r], [0.01 * r, 0.01]], 4000)
    scaled = drawn * np.array([1.0, unit])
    found = of_replicates(("a", "b"), scaled, np.array([2.0, 3.0 * unit]))
    assert found.matrix[0, 1] == pytest.approx(r, abs=0.1)
    assert found.relative == pytest.approx([0.05, 0.1 / 3.0], rel=0.1)


def test_a_fit_of_a_line_has_the_correlation_of_the_textbook() -> None:
    places = np.linspace(1.0, 2.0, 50)

    def left(values: np.ndarray) -> np.ndarray:
        return (values[0] + values[1] * places - (3.0 + 2.0 * places)) / 0.01

    unknowns = (Unknown("level", 0.1, 30.0), Unknown("slope", -20.0, 20.0, logarithmic=False))
    found = of_fit(unknowns, fit(left, unknowns, [np.array([2.5, 1.5])]))
    expected = -places.mean() / np.sqrt(np.mean(places**2))
    assert found.matrix[0, 1] == pytest.approx(expected, abs=1e-3)
    slope_error = 0.01 / np.sqrt(np.sum((places - places.mean()) ** 2))
    assert found.relative[1] == pytest.approx(slope_error / 2.0, rel=1e-3)


def test_a_motion_of_hardly_changing_speed_cannot_tell_viscous_from_coulomb() -> None:
    time = np.arange(20_000) * 1e-3
    # back and forth at nearly one speed
    rate = np.clip(3.0 * np.sin(1.3 * time), -1.0, 1.0) * (1.0 + 0.03 * np.sin(4.0 * time))
    position = np.cumsum(rate) * 1e-3
    noise = 0.05 * np.random.default_rng(0).standard_normal(len(time))
    torque = 0.5 * np.gradient(rate, 1e-3) + 0.8 * rate + 0.3 * np.sign(rate) + noise
    found = fit_rigid_axis(time, position, torque, RigidAxisRule(20.0)).correlations
    i, j = found.worst_pair or (0, 0)
    assert {found.names[i], found.names[j]} == {"viscous", "coulomb"} and found.matrix[i, j] < -0.9
    assert "viscous and coulomb of arm" in found.worst("arm")


def test_the_numbers_of_all_axes_stand_in_one_matrix() -> None:
    told = of_all_axes({"azimuth": pair(-0.5), "tilt": pair(0.25)})
    assert told["names"] == ["azimuth.viscous", "azimuth.coulomb", "tilt.viscous", "tilt.coulomb"]
    assert told["matrix"] == [
        [1.0, -0.5, 0.0, 0.0],
        [-0.5, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.25],
        [0.0, 0.0, 0.25, 1.0],
    ]
    assert of_all_axes({}) == {"names": [], "matrix": []}
