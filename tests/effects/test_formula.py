"""Formulas of a model file: read, held to their units, and run as operations."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.compiling import interpreted
from firmware_protocol.errors import BadInputError
from sim_backend.effects import law_value
from sim_backend.effects.law_program import STACK
from sim_backend.layout import STEP_S, STEPS
from sim_backend.model.formula import dimension_of, formula_program, unit_text
from sim_backend.model.laws import Over

KNOWN = frozenset(Over)
NUMBERS = {"k": (2.0, "N m/rad^3"), "c": (0.5, "N m"), "a": (0.3, "rad"), "w": (0.1, "rad"), "s": (0.2, "rad/s")}


def value(form: str, q: float = 0.7, v: float = -0.4, wanted: str = "N m", **numbers: tuple[float, str]) -> float:
    """What a formula answers at a position and a rate."""
    words = set(re.findall(r"[A-Za-z_]\w*", form))
    used = {name: one for name, one in {**NUMBERS, **numbers}.items() if name in words}
    program = formula_program(form, used, wanted, False, KNOWN, "file")
    P = np.concatenate([np.zeros(16), program.floats])
    P[STEP_S], P[8], P[9] = 1e-3, 16, len(program.operations)
    X = np.zeros(64 + program.states)
    X[STEPS] = 0.0
    return float(interpreted(law_value)(P, 8, X, 64, q, v, 0.6, 25.0))


@pytest.mark.parametrize(
    ("form", "expected"),
    [
        ("k * max(position - a, 0)^3", 2.0 * 0.4**3),
        ("-k * (position - 1 * a)^3", -2.0 * 0.4**3),
        ("k * (a - position)^3", -2.0 * 0.4**3),
        ("c * ((a - position) / w)^2", 0.5 * 16.0),
        ("c * sign(rate) * exp(-(speed / s)^2)", -0.5 * math.exp(-4.0)),
        ("c * sin(3 * position)", 0.5 * math.sin(2.1)),
        ("c * tanh(rate / s) - c / 2 + c * 2 ^ -1", 0.5 * math.tanh(-2.0)),
        ("c * sqrt(abs(position) / a)", 0.5 * math.sqrt(0.7 / 0.3)),
        ("min(c, torque) + max(0, c - c)", 0.5),
        ("c * 3 - c - c", 0.5),
        ("c * (temperature / t)", 0.5),
    ],
)
def test_a_formula_is_what_it_says(form: str, expected: float) -> None:
    assert value(form, t=(25.0, "degC")) == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize(
    ("form", "problem"),
    [
        ("k * position", "is in"),
        ("c + a", "same unit"),
        ("c * exp(position)", "exp of rad"),
        ("c * unknown", "no number or variable"),
        ("c * (1 + 2", "no ')'"),
        ("c c", "the end"),
        ("", "nothing"),
        ("__import__('os')", "a number, a name or a bracket"),
        ("c * position.real", "the end"),
        ("c * max(position, a, w) / a", "function of one"),
        ("c * (position / a) ^ (position)", "power in rad"),
        ("c * " + "(" * 30 + "1" + ")" * 30, "too deep"),
        ("c*hangs_back(0.1)/a", "one of the numbers"),
        ("c*hangs_back(a, a)/a", "for hangs_back"),
        ("c*direction(a, a)", "no ')'"),
        ("c*recent_speed(a)/s", "for recent_speed"),
    ],
)
def test_what_is_wrong_is_said(form: str, problem: str) -> None:
    with pytest.raises(BadInputError, match=r"form|numbers") as refused:
        value(form)
    assert problem in str(refused.value)


def test_a_number_that_stands_nowhere_is_said() -> None:
    with pytest.raises(BadInputError, match="stand in no place"):
        formula_program("c", {"c": (1.0, "N m"), "d": (1.0, "N")}, "N m", False, KNOWN, "file")


@given(st.tuples(*[st.integers(-3, 3)] * 5))
def test_a_unit_that_is_written_is_read_again(dimension: tuple[int, int, int, int, int]) -> None:
    assert dimension_of(unit_text(dimension), "here") == dimension


@given(st.text(alphabet="kcaw positonrae0123456789.+-*/^(),_", max_size=60))
def test_any_text_is_a_formula_or_is_refused(form: str) -> None:
    try:
        program = formula_program(form, NUMBERS, "N m", False, KNOWN, "file")
    except BadInputError:
        return
    assert program.states >= STACK


def _tree(depth: int) -> st.SearchStrategy[str]:
    leaf = st.sampled_from(["position", "a", "w"])
    if depth == 0:
        return leaf
    inner = _tree(depth - 1)
    return st.one_of(
        leaf,
        st.tuples(inner, st.sampled_from("+-"), inner).map(lambda t: f"({t[0]} {t[1]} {t[2]})"),
        st.tuples(st.sampled_from(["min", "max"]), inner, inner).map(lambda t: f"{t[0]}({t[1]}, {t[2]})"),
        inner.map(lambda t: f"abs({t})"),
        inner.map(lambda t: f"-{t}"),
    )


@given(_tree(3), st.floats(-3.0, 3.0))
def test_a_tree_of_operations_is_what_python_makes_of_it(form: str, q: float) -> None:
    there = {"position": q, "a": NUMBERS["a"][0], "w": NUMBERS["w"][0], "abs": abs, "min": min, "max": max}
    expected = eval(form, {"__builtins__": {}}, there)
    assert value(form, q, wanted="rad") == pytest.approx(expected, rel=1e-9, abs=1e-12)
