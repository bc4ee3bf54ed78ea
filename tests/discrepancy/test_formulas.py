"""Formulas after curves: forms say what they compute, are found among others, and stand in a model file."""

from __future__ import annotations

import re

import numpy as np
import pytest

from firmware_protocol.compiling import interpreted
from gimbal_hil.knowledge.discrepancy.laws import Formula, LawShape, effect_source
from gimbal_hil.knowledge.discrepancy.laws import formula as formulas
from gimbal_hil.knowledge.discrepancy.laws.fitting import Written
from gimbal_hil.knowledge.discrepancy.laws.forms import FormTerm, Sense, beside, terms_of
from gimbal_hil.knowledge.discrepancy.laws.formula import formula_for
from gimbal_hil.knowledge.discrepancy.laws.knots import basis
from gimbal_hil.knowledge.discrepancy.laws.linear import FOLDS, Normal
from gimbal_hil.knowledge.discrepancy.laws.saying import Saying
from sim_backend.effects import Effect, Hook, law_value
from sim_backend.effects.law_program import STACK
from sim_backend.layout import STEP_S
from sim_backend.model import ActsOn, Over
from tests.discrepancy.test_laws import ROWS, WEIGHT, straight
from tests.effects.rigs import rotary

POSITION = LawShape("axis", ActsOn.TORQUE, (Over.POSITION,))
SHAPES = (
    POSITION,
    LawShape("axis", ActsOn.TORQUE, (Over.RATE,)),
    LawShape("axis", ActsOn.FRICTION, (Over.SPEED,)),
    LawShape("axis", ActsOn.COMMAND, (Over.TORQUE,)),
    LawShape("axis", ActsOn.TORQUE, (Over.POSITION,), by_direction=True),
    LawShape("axis", ActsOn.TORQUE, (Over.HANGS_BACK,), slack=0.4),
    LawShape("axis", ActsOn.TORQUE, (Over.HANGS_BACK,), slack=0.4, softness=0.5),
    LawShape("axis", ActsOn.FRICTION, (Over.POSITION, Over.SPEED)),
    LawShape("axis", ActsOn.TORQUE, (Over.POSITION, Over.RATE)),
)


def formula(shape: LawShape, terms: tuple[FormTerm, ...]) -> Formula:
    """A formula of these terms with numbers that differ."""
    inner = tuple(0.3 + 0.2 * np.arange(len(term.form.inner)) for term in terms)
    scales = 0.7 + 0.4 * np.arange(sum(term.form.scales for term in terms))
    count = sum(len(term.form.numbers) for term in terms)
    return Formula(shape, Written(terms, inner, 0.0), scales, np.zeros(count), np.ones(count))


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.text)
def test_every_form_is_in_a_model_file_what_it_is_in_the_fit(shape: LawShape) -> None:
    for term in terms_of(shape):
        for parts in beside(shape):
            one = formula(shape, (term, *parts))
            law = rotary().with_law(one.entry(False)).effects[0].law
            assert law is not None
            P = np.concatenate([np.zeros(16), law.program])
            P[STEP_S], P[8], P[9] = 1e-9, 16, law.operations
            for x in (-1.1, -0.2, 0.37, 0.9):
                value = abs(x) if Over.SPEED in shape.over else x
                hangs = shape.over[0] is Over.HANGS_BACK
                X = np.zeros(64 + law.states + 1)
                X[64 + STACK :] = value if hangs else 0.0
                rate = 1e-9 if shape.by_direction or hangs else value
                answered = interpreted(law_value)(P, 8, X, 64, value, rate, value, 20.0)
                there = min(max(value, -0.4), 0.4) if hangs else value
                assert answered == pytest.approx(
                    one.at(*[np.array([there])] * len(shape.over))[0][0], rel=1e-6, abs=1e-9
                ), one.text


def saying(law: np.ndarray, noise: float = 1.0) -> Saying:
    """Rows of one channel that hold a law over x from -1 to 1, (rows,), in floors."""
    rng = np.random.default_rng(5)
    x = rng.uniform(-1.0, 1.0, ROWS)
    left = -np.interp(x, np.linspace(-1.0, 1.0, len(law)), law) + noise * rng.normal(size=ROWS)
    knots = tuple(np.linspace(-1.0, 1.0, 120))
    one = straight(left, np.zeros(ROWS), trust=0.1)
    folds = one.normals(basis(x, knots), 0)
    squares = [float(np.sum((WEIGHT * left[one.fold == k]) ** 2)) for k in range(FOLDS)]
    rows = [WEIGHT**2 * float(np.sum(one.fold == k)) for k in range(FOLDS)]
    assert all(isinstance(fold, Normal) for fold in folds)
    at = np.array(knots)
    return Saying(POSITION, one, (at,), at, folds, np.array(squares), np.array(rows))


X = np.linspace(-1.0, 1.0, 400)


@pytest.mark.parametrize(
    ("phrase", "law", "numbers"),
    [
        pytest.param(
            "a bump",
            30.0 * np.exp(-(((X - 0.3) / 0.1) ** 2)),
            {"a": 30.0, "centre": 0.3, "width": 0.1},
            marks=pytest.mark.heavy,
        ),
        ("a spring beyond an edge", 40.0 * np.maximum(X - 0.2, 0.0), {"k": 40.0, "edge": 0.2}),
        (
            "nothing between two edges, a square beyond",
            -90.0 * np.sign(X) * np.maximum(np.abs(X) - 0.4, 0.0) ** 2,
            {"k": -90.0, "free": 0.4},
        ),
        pytest.param("a wave", 20.0 * np.sin(9.0 * X), {"a": 20.0, "order": 9.0}, marks=pytest.mark.heavy),
    ],
)
def test_the_form_is_found_among_the_others(phrase: str, law: np.ndarray, numbers: dict[str, float]) -> None:
    found = formula_for(saying(law))
    assert found is not None and phrase in (found.phrase, *found.alike)
    if found.phrase == phrase:
        told = found.numbers(False)
        for name, value in numbers.items():
            assert told[name]["value"] == pytest.approx(value, rel=0.15)
            assert told[name]["low"] <= told[name]["value"] <= told[name]["high"]


def test_a_form_of_which_only_the_far_tail_was_seen_gives_way_to_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its scale would be no number of a model file."""
    asked: list[Written] = []
    tail = next(term for term in terms_of(POSITION) if term.form.phrase == "a bump")
    seen = next(term for term in terms_of(POSITION) if term.form.phrase == "a cube")
    given = saying(30.0 * X**3)
    two = [Written((tail,), (np.array([9.0, 0.1]),), 1.0, 0.0), Written((seen,), (np.array([0.0]),), 1.0, 50.0)]

    def interval(saying: Saying, one: Written) -> tuple[np.ndarray, np.ndarray]:
        asked.append(one)
        return (np.array([-1.5e20]), np.array([1.0])) if one.terms == (tail,) else (np.zeros(2), np.ones(2))

    monkeypatch.setattr(formulas, "_written", lambda saying: two)
    monkeypatch.setattr(formulas, "_interval", interval)
    found = formula_for(given)
    assert asked == two and found is not None and found.phrase == "a cube"


def test_noise_gets_no_long_formula() -> None:
    found = formula_for(saying(np.zeros(400)))
    assert found is None or len(found.numbers(False)) <= 3


def test_numbers_of_two_alike_terms_have_names_of_their_own() -> None:
    bump = next(term for term in terms_of(POSITION) if term.form.phrase == "a bump")
    text = formula(POSITION, (bump, bump)).text
    assert {"centre", "centre_2"} <= set(re.findall(r"\w+", text))
    assert FormTerm(bump.form, Sense.OPPOSED).text(("position",), "sign(rate)", {}).startswith("sign(rate) * a")


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.text)
def test_the_skeleton_of_a_plug_in_does_what_the_formula_does(shape: LawShape) -> None:
    for term in terms_of(shape)[::4]:
        one = formula(shape, (term, *beside(shape)[1]))
        source = effect_source(one, "law_1_of_axis", False)
        assert source is not None
        there: dict[str, object] = {}
        exec(compile(source, "law_1_of_axis.py", "exec"), there)
        effect = there["EFFECT"]
        assert isinstance(effect, Effect) and effect.hook is not None
        P = np.array([number["value"] for number in one.numbers(False).values()])
        law = interpreted(effect.law)
        value, X = 0.37, np.array([0.0])
        rate = 1e-9 if shape.by_direction else value
        X[0] = value if shape.over[0] is Over.HANGS_BACK else 0.0
        friction = (value, rate, 0.0, 20.0, 100.0, 100.0, 0.0)
        arguments = {
            Hook.TORQUE: (value, rate, 0.0),
            Hook.COMMAND: (np.zeros(1), value, value, rate),
            Hook.FRICTION: friction,
        }
        answered = law(P, 0, X, 0, *arguments[effect.hook])
        base = {Hook.TORQUE: 0.0, Hook.COMMAND: value, Hook.FRICTION: 100.0}[effect.hook]
        told = answered[0] if effect.hook is Hook.FRICTION else answered
        assert told - base == pytest.approx(one.at(*[np.array([value])] * len(shape.over))[0][0], rel=1e-5, abs=1e-9)
