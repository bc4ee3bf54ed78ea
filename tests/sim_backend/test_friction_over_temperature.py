"""Friction over temperature: a table in the model, in force at each tick's temperature."""

from __future__ import annotations

import numpy as np
import pytest

from sim_backend.layout import IN_FORCE, KNOT_SIZE, SIGMA2, TC, TEMPERATURE, TS
from sim_backend.model import shipped_model
from sim_backend.plant import Plant

MODEL = shipped_model("thesis-temperature")


def in_force(degc: float) -> np.ndarray:
    """Friction of the outer axis after a tick at a temperature: Ts, Tc, vs, sigma0, sigma1, sigma2, delta."""
    plant = Plant(MODEL.with_number("outer", "thermal.ambient", degc))
    plant.run(np.zeros((2, 2)))
    return plant.X[IN_FORCE : IN_FORCE + KNOT_SIZE - 1]


@pytest.mark.parametrize("row", MODEL.friction_over_temperature["outer"], ids=lambda row: f"{row[0]:g} degC")
def test_at_a_knot_the_row_of_the_table_is_in_force(row: tuple[float, ...]) -> None:
    friction = in_force(row[0])
    assert (
        friction[TS] == pytest.approx(row[1])
        and friction[TC] == pytest.approx(row[2])
        and friction[SIGMA2] == pytest.approx(row[6])
    )


def test_between_knots_it_is_linear_and_beyond_them_it_holds() -> None:
    cold, mild = MODEL.friction_over_temperature["outer"][:2]
    middle = 0.5 * (cold[0] + mild[0])
    assert in_force(middle)[SIGMA2] == pytest.approx(0.5 * (cold[6] + mild[6]))
    np.testing.assert_allclose(in_force(-60.0), in_force(-40.0))
    np.testing.assert_allclose(in_force(120.0), in_force(85.0))


def test_at_twenty_degrees_it_is_the_thesis_antenna() -> None:
    torque = np.random.default_rng(1).uniform(-3.0, 3.0, (500, 2))
    np.testing.assert_allclose(
        Plant(MODEL).run(torque).position, Plant(shipped_model()).run(torque).position, rtol=1e-12, atol=1e-15
    )


def test_a_motor_that_heats_its_joint_walks_along_the_table() -> None:
    warm = MODEL.with_number("outer", "thermal.time_constant", 5.0).with_number("outer", "thermal.heating", 2.0)
    plant = Plant(warm)
    plant.run(np.column_stack([np.full(5000, 2.0), np.zeros(5000)]))
    # T' = (20 - T) / 5 s + 2 u^2: the settled rise is 40 K
    assert plant.X[TEMPERATURE] == pytest.approx(20.0 + 40.0 * (1.0 - np.exp(-1.0)), rel=1e-3)
    expected = np.interp(
        plant.X[TEMPERATURE], *zip(*((row[0], row[6]) for row in MODEL.friction_over_temperature["outer"]), strict=True)
    )
    assert plant.X[IN_FORCE + SIGMA2] == pytest.approx(expected, rel=1e-3)
