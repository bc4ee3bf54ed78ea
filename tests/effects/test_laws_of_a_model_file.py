"""Curves that a model file states itself: they run in the plant as the catalogue's laws do, and say what is wrong."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.compiling import interpreted
from firmware_protocol.errors import BadInputError
from sim_backend.effects import Given, Operation, law_value, spline_value, states_of, surface_value
from sim_backend.layout import STEP_S
from sim_backend.model import AntennaModel, LawProgram, Over, model_from_document, put_variable
from tests.effects.rigs import rotary, run, with_effect

SPRING = {"kind": "curve", "axis": "axis", "acts_on": "torque", "over": "position"}
KNOTS = {"knots": [-20.0, -5.0, 0.0, 20.0]}


def _with(model: AntennaModel, **keys: Any) -> AntennaModel:
    return model.with_law({**SPRING, **keys})


def _pushed(model: AntennaModel) -> np.ndarray:
    torque = 0.8 * np.sin(2.0 * np.pi * 0.4 * np.arange(3000) / 1000.0)
    return np.asarray(run(model, torque).position)[:, 0]


def test_a_straight_curve_over_position_is_a_spring() -> None:
    values = [2.0 * -q for q in KNOTS["knots"]]
    curve = _pushed(_with(rotary(), **KNOTS, values=values))
    spring = _pushed(with_effect(rotary(), "cable_spring", stiffness=2.0, rest_position=0.0))
    assert np.abs(spring).max() > 0.1
    np.testing.assert_allclose(curve, spring, atol=1e-9)


def test_a_curve_over_torque_that_acts_on_the_command_is_a_gain() -> None:
    curve = _pushed(_with(rotary(), acts_on="command", over="torque", knots=[-1.0, 1.0], values=[-0.25, 0.25]))
    gain = _pushed(rotary().with_number("axis", "actuator.gain_error", 0.25))
    np.testing.assert_allclose(curve, gain, atol=1e-9)


def test_a_level_curve_that_acts_on_friction_raises_both_levels() -> None:
    friction = {"coulomb": 0.2, "breakaway": 0.25, "stribeck_velocity": 0.01, "sigma0": 200.0, "sigma1": 2.0}
    curve = _pushed(_with(rotary(**friction), acts_on="friction", over="speed", knots=[0.0, 9.0], values=[0.1, 0.1]))
    raised = _pushed(rotary(**friction | {"coulomb": 0.3, "breakaway": 0.35}))
    assert np.abs(raised - _pushed(rotary(**friction))).max() > 0.01
    np.testing.assert_allclose(curve, raised, atol=1e-9)


def test_a_curve_by_direction_is_the_forward_one_forwards_and_the_backward_one_backwards() -> None:
    both = {"forward": [-0.3, -0.3], "backward": [0.1, 0.1], "knots": [-9.0, 9.0]}
    for pushes, opposes in ((1.0, 0.3), (-1.0, 0.1)):
        there = run(_with(rotary(), **both, direction_travel=1e-6), pushes, 1000).position[-1, 0]
        known = run(rotary(), pushes - np.sign(pushes) * opposes, 1000).position[-1, 0]
        assert there == pytest.approx(known, rel=1e-3)


def test_a_surface_is_straight_in_both_variables() -> None:
    keys = {"over": ["position", "rate"], "knots": [[-50.0, 50.0], [-50.0, 50.0]]}
    product = _pushed(_with(rotary(), **keys, values=[[-10.0, 10.0], [10.0, -10.0]]))
    table = np.array([2.0, 2.0, -50.0, 50.0, -50.0, 50.0, -10.0, 10.0, 10.0, -10.0])
    for q, v in ((3.0, 4.0), (-50.0, 50.0), (70.0, 1.0)):
        held = -10.0 * min(q, 50.0) * v / 2500.0
        assert interpreted(surface_value)(table, 0, q, v) == pytest.approx(held)
    assert np.isfinite(product).all() and np.abs(product - _pushed(rotary())).max() > 1e-3


def test_a_curve_over_what_hangs_back_is_a_hysteresis_of_that_slack() -> None:
    held = _with(rotary(), over="hangs_back", slack=0.05, knots=[-0.05, 0.05], values=[0.5, -0.5])
    moved = _pushed(held)
    position, back = 0.0, 0.0
    rate, h = 0.0, 1e-4
    for torque in np.repeat(0.8 * np.sin(2.0 * np.pi * 0.4 * np.arange(3000) / 1000.0), 10):
        back = min(max(back + rate * h, -0.05), 0.05)
        rate += h * (torque - 10.0 * back) / 0.5
        position += h * rate
    assert moved[-1] == pytest.approx(position, abs=2e-3)


@pytest.mark.parametrize(
    ("softness", "expected"),
    [
        (0.0, lambda q: np.minimum(q, 0.05)),
        # Dahl's, and Bouc and Wen's with a square
        (1.0, lambda q: 0.05 * (1.0 - np.exp(-q / 0.05))),
        (0.5, lambda q: 0.05 * np.tanh(q / 0.05)),
    ],
)
def test_what_hangs_back_softly_gives_way_before_its_slack(softness: float, expected: Any) -> None:
    program = put_variable(LawProgram(), Over.HANGS_BACK, slack=0.05, softness=softness)
    P, X = np.concatenate([np.zeros(16), program.floats]), np.zeros(64 + program.states)
    P[STEP_S], P[8], P[9] = 1e-3, 16, len(program.operations)
    back = np.array([interpreted(law_value)(P, 8, X, 64, 0.0, 0.1, 0.0, 20.0) for _ in range(2000)])
    np.testing.assert_allclose(back, expected(1e-4 * np.arange(1, 2001)), atol=1e-4)
    # the other way it springs back at first by more than it is moved
    turned = back[-1] - interpreted(law_value)(P, 8, X, 64, 0.0, -0.1, 0.0, 20.0)
    assert turned == pytest.approx(1e-4 if softness == 0.0 else 2e-4, rel=0.05)


@given(
    st.lists(st.integers(-5000, 5000), min_size=3, max_size=12, unique=True),
    st.integers(0, 1000),
    st.floats(-8.0, 8.0),
)
def test_a_spline_passes_its_knots_is_scipys_between_and_stays_outside(at: list[int], seed: int, asked: float) -> None:
    from scipy.interpolate import CubicSpline

    knots = np.sort(at) / 1000.0
    values = np.random.default_rng(seed).normal(size=len(knots))
    document = {"schema": 1, "name": "rig", "kind": "rotary", "axes": {"axis": {"body": {"inertia": {"zz": 1.0}}}}}
    model = _with(model_from_document(document, "rig"), knots=knots.tolist(), values=values.tolist())
    law = model.effects[0].law
    assert law is not None
    P = np.array(law.program)
    table = int(P[3])
    known = CubicSpline(knots, values, bc_type="natural")(np.clip(asked, knots[0], knots[-1]))
    assert interpreted(spline_value)(P, table, asked) == pytest.approx(float(known), rel=1e-6, abs=1e-6)


def test_memory_and_stack_have_a_place_each() -> None:
    program = put_variable(LawProgram(), Over.HANGS_BACK, slack=0.1)
    program.add(Operation.VARIABLE, Given.RATE).add(Operation.DIRECTION, 0.0)
    assert program.states == states_of(()) + 2


def test_a_law_survives_its_file(tmp_path: Any) -> None:
    from sim_backend.model import load_model

    model = _with(rotary(), **KNOTS, values=[1.0, 0.5, 0.0, -2.0], low=[0.9, 0.4, -0.1, -2.1], high=[1.1, 0.6, 0.1, -1])
    (tmp_path / "model.yaml").write_text(model.to_yaml())
    again = load_model(tmp_path / "model.yaml")
    assert again.effects == model.effects
    np.testing.assert_array_equal(_pushed(again), _pushed(model))


@pytest.mark.parametrize(
    ("keys", "key", "expected"),
    [
        ({"values": [0.0, 1.0]}, "values", "4, one for each knot"),
        ({}, "forward", "`forward` and `backward`"),
        ({"values": [0.0] * 4, "knots": [0.0, 0.0, 1.0, 2.0]}, "knots", "above the one before"),
        ({"values": [0.0] * 4, "over": "torque"}, "over", "position"),
        ({"values": [0.0] * 4, "over": "hangs_back"}, "slack", "above zero"),
        ({"values": [0.0] * 4, "over": "hangs_back", "slack": 0.1, "softness": 1.5}, "softness", "1"),
        ({"values": [0.0] * 4, "unit": "rad"}, "unit", "N m"),
        ({"values": [0.0] * 4, "axis": "other"}, "axis", "axis"),
        ({"values": [0.0] * 4, "over": "colour"}, "over", "'position'"),
        ({"values": [0.0] * 4, "stiffness": 1.0}, "stiffness", ""),
        ({"values": [0.0] * 4, "over": ["position", "rate"]}, "knots", "two lists"),
    ],
)
def test_what_is_wrong_is_said_with_its_key(keys: dict[str, Any], key: str, expected: str) -> None:
    with pytest.raises(BadInputError) as refused:
        _with(rotary(), **{**KNOTS, **keys})
    said = str(refused.value)
    assert (f"effects.0: {key}" in said or f"effects.0.{key}" in said) and expected in said


def test_a_formula_runs_in_the_plant_as_the_curve_through_its_values() -> None:
    numbers = {"k": {"value": 3.0, "unit": "N m/rad^3"}, "edge": {"value": 0.05, "unit": "rad"}}
    entry = {"kind": "formula", "axis": "axis", "acts_on": "torque", "numbers": numbers}
    knots = np.linspace(-1.0, 3.0, 200)
    values = -3.0 * np.maximum(knots - 0.05, 0.0) ** 3
    drawn = _pushed(_with(rotary(), knots=knots.tolist(), values=values.tolist()))
    formula = _pushed(rotary().with_law({**entry, "form": "-k * max(position - edge, 0)^3"}))
    assert np.abs(drawn - _pushed(rotary())).max() > 1e-2
    np.testing.assert_allclose(formula, drawn, atol=1e-4)
    with pytest.raises(BadInputError, match="numbers: sin is taken"):
        rotary().with_law({**entry, "form": "sin", "numbers": {"sin": numbers["k"]}})
