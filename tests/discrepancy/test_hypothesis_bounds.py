"""Whatever a search tries is an antenna that can be: neutral where its coordinates are zero, and never beyond the
catalogue's bounds.
"""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.hypotheses.evidence import families
from gimbal_hil.knowledge.discrepancy.hypotheses.families import Family
from gimbal_hil.knowledge.discrepancy.hypotheses.fit import FitRule, Weighing, fit
from gimbal_hil.knowledge.discrepancy.hypotheses.hypothesis import (
    Cause,
    Hypothesis,
    KnownNumber,
    at_bound,
    parameters_of,
    values_of,
)
from gimbal_hil.knowledge.discrepancy.judgement import intervals
from gimbal_hil.knowledge.discrepancy.twin.number_slots import read_number, write_number
from gimbal_hil.knowledge.discrepancy.twin.record import record_of
from gimbal_hil.knowledge.discrepancy.twin.twin import Twin
from sim_backend.effects import Move
from sim_backend.model import AntennaModel, load_model, shipped_model, shipped_model_path


def odd_model() -> AntennaModel:
    """The shipped antenna with a lag of its own and a bristle without damping."""
    return shipped_model().with_numbers("outer", {"actuator.time_constant": 2e-3, "friction.sigma1": 0.0})


def twin_of(model: AntennaModel) -> Twin:
    t = np.arange(4000) * 1e-3
    columns = {f"{axis}.{signal}": np.sin(3.0 * t) for axis in model.axes for signal in ("torque", "position", "rate")}
    return Twin(model, (record_of(SignalsTable.of(model.axes, t, columns), model, 25.0, "log"),))


def named(twin: Twin, effect: str, axis: str = "outer") -> Family:
    return next(family for family in families(twin, axis) if family.effect == effect)


@pytest.mark.parametrize("model", [shipped_model(), odd_model()], ids=["shipped", "odd"])
@pytest.mark.parametrize("axis", ["outer", "inner"])
def test_a_cause_whose_coordinates_are_zero_leaves_the_model_as_it_is(model: AntennaModel, axis: str) -> None:
    twin = twin_of(model)
    for family in families(twin, axis):
        if all(knob.move is not Move.LEVEL for knob in family.knobs):
            structure, P = parameters_of(twin, Hypothesis((Cause(family, (0.0,) * len(family.knobs)),)))
            # a lag that moves never quite vanishes: a millionth of a second in a step of one thousandth
            least = 2e-3 if family.effect == "actuator_lag" else 0.0
            assert np.allclose(P, structure.P, rtol=1e-12, atol=least), family.effect


def test_a_lag_adds_to_the_one_that_the_model_states() -> None:
    twin = twin_of(odd_model())
    hypothesis = Hypothesis((Cause(named(twin, "actuator_lag"), (3.0,)),))
    assert values_of(twin.model, twin, hypothesis, 0)["time_constant"] == pytest.approx((5e-3, 2e-3))


@pytest.mark.parametrize("value", [0.0, 3e-6, 1e-3, 0.2])
def test_a_number_is_read_as_it_was_written(value: float) -> None:
    model = shipped_model()
    twin = twin_of(model)
    P = twin.structure(()).P.copy()
    for path in ("actuator.time_constant", "friction.viscous", "body.own_inertia"):
        write_number(model, P, "inner", path, value)
        least = 1e-6 if path == "actuator.time_constant" else 0.0
        assert read_number(model, P, "inner", path) == pytest.approx(max(value, least), rel=1e-9)


def test_two_causes_together_leave_a_number_within_the_catalogues_bounds() -> None:
    twin = twin_of(shipped_model())
    lower = tuple(Cause(named(twin, name), (-9.0, *rest)) for name, rest in (("coulomb", ()), ("stribeck", (0.0, 0.0))))
    hypothesis = Hypothesis().plus(lower[0]).plus(lower[1])
    _, P = parameters_of(twin, hypothesis)
    assert read_number(twin.model, P, "outer", "friction.breakaway") >= 0.0
    twice = tuple(Cause(named(twin, "torque_gain"), (-15.0,)) for _ in range(2))
    _, P = parameters_of(twin, Hypothesis(twice))
    assert read_number(twin.model, P, "outer", "actuator.gain_error") == pytest.approx(-0.9)


@pytest.mark.parametrize(
    ("effect", "x"), [("dynamic_unbalance", (60.0, -80.0, 40.0)), ("inertia", (30.0,)), ("inertia", (-18.0,))]
)
@pytest.mark.parametrize("axis", ["outer", "inner"])
def test_a_body_that_is_tried_is_one_that_a_model_file_may_have(axis: str, effect: str, x: tuple[float, ...]) -> None:
    twin = twin_of(shipped_model())
    hypothesis = Hypothesis().plus(Cause(named(twin, effect, axis), x))
    values = {name: value for name, (value, _) in values_of(twin.model, twin, hypothesis, 0).items()}
    changed = twin.model.with_effect(effect, axis, values)
    assert any(
        changed.number(axis, f"body.inertia.{k}") != twin.model.number(axis, f"body.inertia.{k}")
        for k in ("yy", "zz", "xy", "xz")
    )


def test_a_cause_says_which_of_its_numbers_can_go_no_further() -> None:
    twin = twin_of(shipped_model())
    viscous = named(twin, "viscous")
    assert Hypothesis().plus(Cause(viscous, (-1e9,))).causes[0].knobs_at_bound == ("viscous",)
    assert Hypothesis().plus(Cause(viscous, (1.0,))).causes[0].knobs_at_bound == ()
    assert Hypothesis().plus(Cause(named(twin, "transport_delay"), (80.0,))).causes[0].knobs_at_bound == ("delay",)


def test_a_nuisance_at_its_bound_is_no_reason_to_doubt_the_cause() -> None:
    twin = twin_of(shipped_model())
    bump = named(twin, "stribeck")
    shape = next(j for j, knob in enumerate(bump.knobs) if knob.parameters == ("shape",))
    x = tuple(bump.knobs[j].high if j == shape else 0.1 for j in range(len(bump.knobs)))
    assert Cause(bump, x).knobs_at_bound == ()
    assert Cause(bump, tuple(0.1 if j == shape else knob.high for j, knob in enumerate(bump.knobs))).knobs_at_bound


@pytest.mark.parametrize(("damping", "bound"), [(0.01, ()), (0.05, ()), (0.2, ("damping_ratio",))])
def test_what_hardly_rings_is_no_resonance_and_one_that_rings_for_long_may_be(
    damping: float, bound: tuple[str, ...]
) -> None:
    twin = twin_of(shipped_model())
    resonance = named(twin, "structural_resonance")
    at = tuple((damping - 0.02) / 0.02 if knob.parameters == ("damping_ratio",) else 0.5 for knob in resonance.knobs)
    assert Cause(resonance, at).knobs_at_bound == bound


def test_a_number_that_recalibration_leads_to_its_bound_stands_there_whatever_its_cause_says() -> None:
    twin = twin_of(load_model(shipped_model_path("emps")))
    halved = Hypothesis().plus(Cause(named(twin, "inertia", "carriage"), (-10.0,)))
    gone = replace(halved, floating=(KnownNumber("carriage", "body.mass", 0.02),), y=(-9.0,))
    assert at_bound(twin, halved, 0) == ()
    assert gone.causes[0].knobs_at_bound == ()
    assert at_bound(twin, gone, 0) == ("inertia",)


def test_what_is_pressed_against_a_bound_ends_just_before_it_and_stands_there() -> None:
    twin = twin_of(shipped_model())
    gap = named(twin, "backlash")
    at = {name: i for i, knob in enumerate(gap.knobs) for name in knob.parameters}["gap"]
    for before_the_end, pressed in ((0.005, True), (0.05, False)):
        x = [0.5 * (knob.low + knob.high) if np.isfinite(knob.low + knob.high) else 0.0 for knob in gap.knobs]
        x[at] = gap.knobs[at].high - before_the_end
        assert ("gap" in Cause(gap, tuple(x)).knobs_at_bound) is pressed


def test_a_small_strength_is_not_at_its_bound_but_an_order_at_its_lowest_is() -> None:
    twin = twin_of(odd_model())
    spring = named(twin, "cable_spring")
    assert Cause(spring, (1e-3, 0.5)).knobs_at_bound == ()
    ripple = named(twin, "cogging")
    lowest = next(knob.low for knob in ripple.knobs if knob.parameters == ("order",))
    assert Cause(ripple, (3.0, lowest, 0.2)).knobs_at_bound == ("order",)


def test_at_the_edge_of_what_bodies_there_are_a_derivative_is_one_of_what_is_inside() -> None:
    # with its largest moment all but the sum of the others, a step that makes it larger is led back
    model = shipped_model().with_numbers(
        "inner",
        {f"body.inertia.{one}": value for one, value in zip(("xx", "yy", "zz"), (0.04, 0.0799, 0.04), strict=True)},
    )
    twin = twin_of(model)
    floating = tuple(KnownNumber("inner", f"body.inertia.{one}", 0.2) for one in ("xx", "yy", "zz"))
    weighing = Weighing((1.0,) * len(twin.channels), 1.0)
    floor = np.full(len(twin.channels), 1e-3)
    # one round gives the derivatives where it begins: at the edge, and well inside
    edge, inside = (
        fit(twin, Hypothesis(floating=floating, y=(0.0, y, 0.0)), floor, weighing, FitRule(1)).jacobian
        for y in (math.log(0.08 / 0.0799), -0.1)
    )
    size = np.linalg.norm(inside, axis=0)
    assert np.all(size[1:] > 0.0)
    assert np.linalg.norm(edge - inside, axis=0) == pytest.approx(0.0, abs=0.2 * float(size.max()))


@pytest.mark.parametrize(
    ("effect", "inside", "error", "reaches"),
    [
        # a tenth of a step from the end of each of its coordinates, with an interval beyond it or not
        ("structural_resonance", 0.1, 0.05, ("inertia_share",)),
        ("structural_resonance", 0.1, 0.03, ()),
        # a bump of friction whose speed nobody knows is a bump all the same
        ("stribeck", 0.1, 0.05, ()),
    ],
)
def test_a_strength_whose_interval_reaches_the_end_of_what_is_sought_stands_at_it(
    effect: str, inside: float, error: float, reaches: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    family = named(twin_of(shipped_model()), effect)
    other = Cause(family, tuple(knob.low for knob in family.knobs))
    cause = Cause(family, tuple(knob.high - inside for knob in family.knobs))
    size = len(other.x) + len(cause.x)
    monkeypatch.setattr(intervals, "covariance", lambda *_: error**2 * np.eye(size))
    state: Any = SimpleNamespace(hypothesis=Hypothesis((other, cause)))
    inquiry: Any = None
    assert intervals.strengths_to_their_end(inquiry, state, 1) == reaches


def test_nothing_is_no_end_of_a_strength(monkeypatch: pytest.MonkeyPatch) -> None:
    family = named(twin_of(shipped_model()), "structural_resonance")
    cause = Cause(family, tuple(0.5 * (knob.low + min(knob.high, 1.0)) for knob in family.knobs[:2]) + (0.01,))
    monkeypatch.setattr(intervals, "covariance", lambda *_: np.eye(len(cause.x)))
    state: Any = SimpleNamespace(hypothesis=Hypothesis((cause,)))
    inquiry: Any = None
    assert intervals.strengths_to_their_end(inquiry, state, 0) == ()
