"""Curves where no name fits: knots, the fit beside known numbers, and how a curve stands in a model file."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gimbal_hil.knowledge.discrepancy.hypotheses import Hypothesis, command_residual
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry
from gimbal_hil.knowledge.discrepancy.laws import Curve, LawShape, curve, finding
from gimbal_hil.knowledge.discrepancy.laws.knots import (
    Factor,
    RangeSeen,
    basis,
    bends_of,
    columns_of,
    knots_of,
    knots_where_it_bends,
)
from gimbal_hil.knowledge.discrepancy.laws.linear import FOLDS, JUDGES, Foretold, Normal, Straight, softest
from gimbal_hil.knowledge.discrepancy.laws.shape import crossed
from gimbal_hil.knowledge.discrepancy.twin import Twin
from sim_backend.model import ActsOn, Over
from tests.discrepancy.test_parts_of_the_twin import MODEL, RECORD
from tests.effects.rigs import rotary, run

ROWS, WEIGHT = 800, 0.5


def straight(left: np.ndarray, slopes: np.ndarray, trust: float) -> Straight:
    """One channel, one known number, the last fifth of the rows judging."""
    fold = (np.arange(len(left)) * 20 // len(left)) % FOLDS
    fold[4 * len(left) // 5 :] = JUDGES
    numbers = slopes[:, None, None]
    known = []
    for k in range(FOLDS):
        J = slopes[fold == k][:, None]
        known.append(Normal(WEIGHT**2 * J.T @ J, -(WEIGHT**2) * J.T @ left[fold == k]))
    one = np.array([1.0 / trust])
    return Straight(left[:, None], numbers, np.zeros(1), one, np.array([trust]), fold, WEIGHT, tuple(known))


def scene(seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.uniform(-1.0, 1.0, ROWS), rng.normal(size=ROWS)


@given(st.sampled_from(list(Over)), st.floats(-9.0, 9.0), st.floats(0.01, 9.0), st.integers(3, 85))
def test_knots_ascend_from_end_to_end(over: Over, low: float, width: float, count: int) -> None:
    knots = knots_of(over, low, low + width, count)
    assert len(knots) == count and np.all(np.diff(knots) > 0.0)
    assert knots[0] == pytest.approx(low) and knots[-1] == pytest.approx(low + width)


def test_knots_go_where_the_curve_bends() -> None:
    even = tuple(np.linspace(-1.0, 1.0, 22))
    bump = np.exp(-0.5 * ((np.array(even) - 0.4) / 0.08) ** 2)
    knots = np.array(knots_where_it_bends(even, [bump], 12))
    near = np.sum(np.abs(knots - 0.4) < 0.3)
    assert near >= 7 and np.all(np.diff(knots) > 0.0) and np.sum(np.abs(np.array(even) - 0.4) < 0.3) * 12 / 22 < near
    x = np.linspace(-1.0, 1.0, 400)
    truth = np.exp(-0.5 * ((x - 0.4) / 0.08) ** 2)

    def missed(at: tuple[float, ...]) -> float:
        drawn = basis(x, at)
        return float(np.std(truth - drawn @ np.linalg.lstsq(drawn, truth, rcond=None)[0]))

    assert missed(tuple(knots)) < 0.5 * missed(tuple(np.linspace(-1.0, 1.0, 12)))


def test_a_curve_is_found_beside_a_known_number_that_keeps_its_uncertainty() -> None:
    x, noise = scene()
    slopes = 5.0 * np.sign(x)
    # the number is off by three times what it is known to: the curve has to take the rest
    left = noise - 6.0 * np.maximum(x - 0.3, 0.0) ** 2 * 10.0 - 0.3 * slopes
    knots = knots_of(Over.POSITION, -1.0, 1.0, 9)
    columns, fitted = basis(x, knots), straight(left, slopes, trust=0.1)
    found = fitted.solved(fitted.normals(columns, 0))
    assert found.moved[0] == pytest.approx(0.1)
    assert found.values[-1] == pytest.approx(60.0 * 0.49 + 1.0, rel=0.1)
    after = fitted.after(columns, 0, found)
    assert np.mean(after[fitted.judging] ** 2) < 1.5 and np.mean(left[fitted.judging] ** 2) > 20.0


def test_what_is_no_function_of_the_variable_is_not_foretold() -> None:
    x, noise = scene()
    still = straight(noise, np.zeros(ROWS), trust=0.1)
    shape, both = (
        LawShape("axis", ActsOn.TORQUE, (Over.POSITION,)),
        [(knots_of(Over.POSITION, -1, 1, n),) for n in (3, 60)],
    )
    few, many = (still.foretold(basis(x, knots[0]), 0, 0.0 * bends_of(shape, knots)).leaves for knots in both)
    level = float(np.mean(noise[~still.judging] ** 2))
    assert few > 0.97 * level and many > few


class Leaving:
    """What curves with so many knots leave: a narrow bump, which few knots draw worse than fewer."""

    judging = np.zeros(8 * ROWS, dtype=bool)

    def foretold(self, columns: np.ndarray, channel: int, bends: np.ndarray) -> Foretold:
        by_count = {3: 90.0, 4: 175.0, 5: 182.0, 7: 158.0, 9: 120.0, 12: 10.6, 16: 4.3}
        return Foretold(by_count.get(columns.shape[1], 4.4), bends)


def test_a_bump_that_few_knots_draw_worse_than_none_is_looked_for_with_more(monkeypatch: pytest.MonkeyPatch) -> None:
    x = np.linspace(-1.0, 1.0, 8 * ROWS)
    monkeypatch.setattr(curve, "channel_of", lambda inquiry, axis: 0)
    monkeypatch.setattr(curve, "columns_on", lambda inquiry, seen, knots, factor: basis(x, knots[0]))
    inquiry = cast(Inquiry, SimpleNamespace(twin=SimpleNamespace(records=(0,))))
    seen = RangeSeen(LawShape("axis", ActsOn.TORQUE, (Over.RATE,)), [(x,)], [])
    found = curve.tried(inquiry, cast(Straight, Leaving()), seen, curve.COUNTS)
    assert found is not None and len(found.knots[0]) == 16


def test_a_product_of_two_curves_is_found_that_no_surface_of_few_knots_draws(monkeypatch: pytest.MonkeyPatch) -> None:
    """A narrow bump over position that grows with the rate: the second curve is what the first leaves to it."""
    rng = np.random.default_rng(5)
    t = np.arange(6 * ROWS) / (0.15 * ROWS)
    x, v = np.sin(3.1 * t), rng.uniform(0.1, 3.0) * np.cos(0.37 * t)
    left = rng.normal(size=len(t)) - 30.0 * np.exp(-(((x - 0.3) / 0.06) ** 2)) * np.tanh(v / 0.8)
    axis = SimpleNamespace(records=(0,))
    inquiry = cast(Inquiry, SimpleNamespace(twin=axis))
    over = {Over.POSITION: x, Over.RATE: v}

    def seen_of(inquiry: Inquiry, shape: LawShape) -> RangeSeen:
        return RangeSeen(shape, [tuple(over[one] for one in shape.over)], [np.sign(v)] if shape.by_direction else [])

    def columns_on(inquiry: Inquiry, seen: RangeSeen, knots: Any, factor: Factor | None = None) -> np.ndarray:
        parts = [basis(column, its) for column, its in zip(seen.columns[0], knots, strict=True)]
        if factor is not None:
            return np.asarray((parts[factor.which] @ factor.values)[:, None] * parts[1 - factor.which])
        if len(parts) == 2:
            return np.asarray((parts[0][:, :, None] * parts[1][:, None, :]).reshape(len(x), -1))
        forward = (v > 0.0)[:, None]
        return np.hstack([forward * parts[0], ~forward * parts[0]])

    for name, fake in (("seen_of", seen_of), ("columns_on", columns_on), ("channel_of", lambda inquiry, axis: 0)):
        monkeypatch.setattr(curve, name, fake)
    fitted = straight(left, np.zeros(len(t)), trust=0.1)
    by_direction = LawShape("axis", ActsOn.TORQUE, (Over.POSITION,), by_direction=True, direction_travel=1e-6)
    rate = LawShape("axis", ActsOn.TORQUE, (Over.RATE,))
    (both,) = crossed(by_direction, (rate, LawShape("axis", ActsOn.TORQUE, (Over.TEMPERATURE,))))
    assert both == LawShape("axis", ActsOn.TORQUE, (Over.POSITION, Over.RATE))
    one = curve.tried(inquiry, fitted, seen_of(inquiry, by_direction), curve.COUNTS)
    assert one is not None
    surface = curve.tried(inquiry, fitted, seen_of(inquiry, both), curve.COUNTS)
    product = curve.multiplied(inquiry, fitted, one, both)
    assert surface is not None and product is not None and product.factor is not None
    assert product.leaves < 0.5 * min(surface.leaves, one.leaves) and product.leaves < 2.0
    values = curve.curve_from(inquiry, fitted, product).rows[0]
    assert np.linalg.matrix_rank(values) == 1 and values.shape == tuple(map(len, product.knots))
    strongest = np.unravel_index(np.argmax(np.abs(values)), values.shape)[0]
    assert product.knots[0][strongest] == pytest.approx(0.3, abs=0.03)


def test_a_product_keeps_being_one_while_its_memory_is_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Friction that recent motion takes away: of three first memories none is right."""
    h = 0.01
    speed = np.repeat(np.random.default_rng(5).uniform(0.1, 2.0, 60), 100)

    def recent(memory_s: float) -> np.ndarray:
        found, now = np.zeros(len(speed)), 0.0
        for k, each in enumerate(speed):
            now += (each - now) * h / memory_s
            found[k] = now
        return found

    def seen_of(inquiry: Inquiry, shape: LawShape) -> RangeSeen:
        over = {Over.SPEED: speed, Over.RECENT_SPEED: recent(shape.memory_s or 1.0)}
        return RangeSeen(shape, [tuple(over[one] for one in shape.over)], [])

    def columns_on(inquiry: Inquiry, seen: RangeSeen, knots: Any, factor: Factor | None = None) -> np.ndarray:
        parts = [basis(column, its) for column, its in zip(seen.columns[0], knots, strict=True)]
        assert factor is not None
        return np.asarray((parts[factor.which] @ factor.values)[:, None] * parts[1 - factor.which])

    for name, fake in (("seen_of", seen_of), ("columns_on", columns_on), ("channel_of", lambda inquiry, axis: 0)):
        monkeypatch.setattr(curve, name, fake)
    inquiry = cast(Inquiry, SimpleNamespace(twin=SimpleNamespace(records=(SimpleNamespace(seconds=60.0),))))
    noise = np.random.default_rng(6).normal(size=len(speed))
    fitted = straight(noise - 30.0 * speed * np.exp(-2.0 * recent(3.1)), np.zeros(len(speed)), trust=0.1)
    shape = LawShape("axis", ActsOn.FRICTION, (Over.SPEED, Over.RECENT_SPEED), memory_s=1.5)
    plain = (0.0, 1.0, 2.0)
    first = curve._times_another(inquiry, fitted, seen_of(inquiry, shape), plain, Factor(0, np.array(plain)), 7)
    found = curve.sharpened(inquiry, fitted, first)
    assert first.leaves > 2.0 > 1.2 > found.leaves and found.factor is not None
    assert found.seen.shape.memory_s == pytest.approx(3.1, rel=0.12)


def test_what_hangs_back_gets_its_slack_and_its_softness(monkeypatch: pytest.MonkeyPatch) -> None:
    t = 0.01 * np.arange(6000)
    record = SimpleNamespace(motion=np.sin(0.9 * t) + 0.6 * np.sin(2.3 * t))

    def hanging_back(slack: float, softness: float) -> np.ndarray:
        found, back = np.zeros(len(t)), 0.0
        for k, step in enumerate(np.diff(record.motion, prepend=0.0)):
            comes = (abs(back) / slack) ** (1.0 / softness) if softness > 0.0 else 0.0
            back = min(max(back + step - abs(step) * np.sign(back) * comes, -slack), slack)
            found[k] = back
        return found

    def seen_of(inquiry: Inquiry, shape: LawShape) -> RangeSeen:
        return RangeSeen(shape, [(hanging_back(shape.slack or 1.0, shape.softness),)], [])

    monkeypatch.setattr(curve, "seen_of", seen_of)
    monkeypatch.setattr(
        curve, "columns_on", lambda inquiry, seen, knots, factor=None: basis(seen.columns[0][0], knots[0])
    )
    monkeypatch.setattr(curve, "channel_of", lambda inquiry, axis: 0)
    inquiry = cast(Inquiry, SimpleNamespace(twin=SimpleNamespace(records=(SimpleNamespace(seconds=60.0),))))
    noise = np.random.default_rng(6).normal(size=len(t))
    for softness in (0.0, 1.0):
        fitted = straight(noise - 100.0 * hanging_back(0.2, softness), np.zeros(len(t)), trust=0.1)
        shape = LawShape("axis", ActsOn.TORQUE, (Over.HANGS_BACK,), slack=0.35, softness=0.5)
        first = curve.tried(inquiry, fitted, seen_of(inquiry, shape), curve.COUNTS)
        assert first is not None
        found = curve.sharpened(inquiry, fitted, first)
        assert found.leaves < 1.3 and found.seen.shape.softness == pytest.approx(softness, abs=0.15)
        assert found.seen.shape.slack == pytest.approx(0.2, rel=0.1)


def steep(furthest: float) -> tuple[Straight, np.ndarray]:
    """A cube over a rate that only one stretch takes to its end, (rows,)."""
    v = 1.0 * np.sin(np.linspace(0.0, 400.0, 4 * ROWS))
    end = slice(2 * ROWS, 2 * ROWS + ROWS // 20)
    v[end] = np.linspace(1.0, furthest, ROWS // 20)
    left = np.random.default_rng(5).normal(size=len(v)) - 40.0 * v**3
    return straight(left, np.zeros(len(v)), trust=0.1), v


def test_a_curve_goes_straight_on_where_no_other_stretch_was() -> None:
    fitted, v = steep(1.5)
    knots = (tuple(np.linspace(-1.0, 1.5, 22)),)
    columns = basis(v, knots[0])
    shape = LawShape("axis", ActsOn.TORQUE, (Over.RATE,))
    bends = bends_of(shape, knots)
    without, with_it = (fitted.foretold(columns, 0, part).leaves for part in (0.0 * bends, bends))
    assert with_it < 0.2 * without


def test_a_narrow_shape_at_which_few_stretches_were_is_foretold_by_many_knots() -> None:
    """Soft knots of which the other stretches hold few rows go anywhere; stiff ones would not draw it."""
    t = np.linspace(0.0, 1.0, 6 * ROWS)
    x = np.sin(9.0 * t) * np.cos(23.0 * t)
    left = np.random.default_rng(5).normal(size=len(x)) - 60.0 * np.exp(-(((x - 0.3) / 0.05) ** 2))
    fitted = straight(left, np.zeros(len(x)), trust=0.1)
    shape, knots = LawShape("axis", ActsOn.TORQUE, (Over.POSITION,)), (tuple(np.linspace(-1.0, 1.0, 120)),)
    columns, bends = basis(x, knots[0]), bends_of(shape, knots)
    found = fitted.foretold(columns, 0, bends)
    soft = fitted.foretold(columns, 0, 1e-3 * softest(bends)).leaves
    assert found.leaves < 1.5 and found.leaves < 0.7 * soft


def test_friction_is_asked_beside_the_bristles_too() -> None:
    friction = LawShape("axis", ActsOn.FRICTION, (Over.RECENT_SPEED,), direction_travel=1e-6, memory_s=5.0)
    shapes = [LawShape("axis", ActsOn.TORQUE, (over,)) for over in (Over.POSITION, Over.RATE)]
    (both,) = crossed(friction, tuple(shapes))
    assert both == LawShape("axis", ActsOn.TORQUE, (Over.RATE, Over.RECENT_SPEED), memory_s=5.0)
    assert not list(crossed(replace(friction, over=(Over.SPEED,), memory_s=None), tuple(shapes)))


def test_one_variable_that_draws_all_there_is_asks_for_no_second_one(monkeypatch: pytest.MonkeyPatch) -> None:
    fitted, v = steep(1.5)
    x = np.cos(np.linspace(0.0, 130.0, len(v)))
    monkeypatch.setattr(curve, "channel_of", lambda inquiry, axis: 0)
    monkeypatch.setattr(curve, "columns_on", lambda inquiry, seen, knots: basis(seen.columns[0][0], knots[0]))
    inquiry = cast(Inquiry, SimpleNamespace(twin=SimpleNamespace(records=(0,))))
    seen = [
        RangeSeen(LawShape("axis", ActsOn.TORQUE, (over,)), [(each,)], [])
        for over, each in ((Over.RATE, v), (Over.POSITION, x))
    ]
    own, other = (curve.leaves_of_its_own(inquiry, fitted, one) for one in seen)
    assert own < 1.5 < 100.0 < other


def test_a_control_takes_nothing_by_a_known_number_that_it_sets_free() -> None:
    """What a number does is the law and something of another time: with that it would draw the law."""
    x = np.random.default_rng(5).uniform(-1.0, 1.0, 8 * ROWS)
    law, shift = 20.0 * x**3, 0.31
    left = np.random.default_rng(6).normal(size=len(x)) - law
    other = np.roll(40.0 * np.cos(3.0 * x), int(shift * len(x)))
    fitted = straight(left, law + other, trust=2.0)
    knots = (tuple(np.linspace(-1.0, 1.0, 9)),)
    seen = RangeSeen(LawShape("axis", ActsOn.TORQUE, (Over.POSITION,)), [(x,)], [])
    one = curve.Tried(seen, knots, basis(x, knots[0]), 1.0, bends_of(seen.shape, knots))
    taken = curve.control_of(fitted, one, 0, (shift,))
    assert taken < 0.1 * np.mean(law**2)


@pytest.mark.parametrize(
    ("shape", "knots"),
    [
        (LawShape("axis", ActsOn.TORQUE, (Over.RATE,)), ((-1.0, 0.2, 0.5, 2.0),)),
        (LawShape("axis", ActsOn.TORQUE, (Over.POSITION,), True), ((-1.0, 0.2, 0.5, 2.0),)),
        (LawShape("axis", ActsOn.TORQUE, (Over.POSITION, Over.RATE)), ((-1.0, 0.2, 0.5, 2.0), (0.0, 1.0, 4.0))),
    ],
)
def test_what_is_straight_does_not_bend(shape: LawShape, knots: Any) -> None:
    first = np.array(knots[0])
    values = np.outer(first, np.ones(len(knots[1]))) + knots[1] if len(knots) == 2 else first
    flat = np.concatenate([values, 3.0 - values]) if shape.by_direction else np.ravel(values)
    bends = bends_of(shape, knots)
    np.testing.assert_allclose(bends @ flat, 0.0, atol=1e-12)
    assert np.abs(bends @ flat**2).max() > 0.1


def test_what_differs_in_its_memory_alone_takes_one_place_among_those_looked_at_closely() -> None:
    hanging = [LawShape("axis", ActsOn.TORQUE, (Over.HANGS_BACK,), slack=slack) for slack in (0.1, 0.2, 0.4)]
    shapes = [*hanging, LawShape("axis", ActsOn.TORQUE, (Over.POSITION,))]
    shapes.append(LawShape("axis", ActsOn.TORQUE, (Over.POSITION,), by_direction=True))
    leaves = (3.0, 1.0, 2.0, 9.0, 8.0)
    looked = [
        cast(Any, SimpleNamespace(seen=SimpleNamespace(shape=shape), leaves=left))
        for shape, left in zip(shapes, leaves, strict=True)
    ]
    assert [one.leaves for one in finding._of_each_kind(looked)] == [1.0, 8.0, 9.0]


def test_where_a_law_does_not_stand_its_tests_the_next_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(finding, "Straight", SimpleNamespace(of=lambda *_: None))
    monkeypatch.setattr(finding, "_best", lambda *_: iter(("over two", "over one")))
    monkeypatch.setattr(finding, "_asked", lambda *given: given[-1] if given[-1] == "over one" else None)
    nothing = cast(Any, SimpleNamespace(inquiry=None, state=None))
    assert cast(Any, finding._one_more(nothing, nothing, np.array([True]), nothing)) == "over one"


def test_what_a_friction_level_does_is_what_the_model_with_it_says() -> None:
    """A level that changes with the speed moves the bristles as well, and their damping answers to that."""
    shape = LawShape("inner", ActsOn.FRICTION, (Over.SPEED,), direction_travel=5e-4)
    knots, values = ((0.0, 0.1, 0.2, 0.3, 0.4, 0.8),), [0.0, 0.0, 0.03, 0.0, 0.0, 0.0]
    seen = RangeSeen.of(shape, (RECORD,), MODEL.axes.index("inner"))
    columns = columns_of(Twin(MODEL, (RECORD,)), (RECORD,), seen, knots, 1.0)
    rows = []
    for model in (MODEL, MODEL.with_law(_curve(shape, knots, values).entry(False))):
        twin = Twin(model, (RECORD,))
        rows.append(command_residual(twin, Hypothesis(), np.ones(len(twin.channels)))[:, 1])
    change = rows[1] - rows[0]
    assert np.std(change) > 1e-3
    assert np.std(change - columns @ np.array(values)) < 0.25 * np.std(change)


def _curve(shape: LawShape, knots: Any, values: list[float]) -> Curve:
    at = np.array(values)
    return Curve(shape, knots, at, at - 0.1, at + 0.1)


def test_a_curve_stands_in_a_model_file_as_it_was_fitted() -> None:
    both = LawShape("axis", ActsOn.TORQUE, (Over.POSITION,), by_direction=True, direction_travel=1e-6)
    law = _curve(both, ((-9.0, 0.0, 9.0),), [-0.3, -0.3, -0.3, 0.1, 0.1, 0.1])
    model = rotary().with_law(law.entry(False))
    ahead = run(model, 1.0, 1000).position[-1, 0]
    assert ahead == pytest.approx(run(rotary(), 0.7, 1000).position[-1, 0], rel=1e-3)
    assert [line.name for line in law.lines()] == ["forward", "backward"]
    assert all(np.all(line.low < line.y) and np.all(line.y < line.high) for line in law.lines())


def test_a_surface_stands_there_row_by_row() -> None:
    shape = LawShape("axis", ActsOn.FRICTION, (Over.SPEED, Over.RECENT_SPEED), memory_s=2.0)
    law = _curve(shape, ((0.0, 1.0), (0.0, 0.5, 1.0)), [0.0, 0.1, 0.2, 0.3, 0.4, 0.5])
    entry = law.entry(False)
    assert entry["values"] == [[0.0, 0.1, 0.2], [0.3, 0.4, 0.5]] and entry["memory_s"] == 2.0
    assert rotary().with_law(entry).effects[0].law is not None
    assert len(law.lines()) == 3
