"""What is asked whether it predicts a remainder: the variables of an axis, their past, and what is beside it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy.inquiry import Policy
from gimbal_hil.knowledge.discrepancy.judgement import exhaustion, judging
from gimbal_hil.knowledge.discrepancy.judgement.exhaustion import Predictable
from gimbal_hil.knowledge.discrepancy.judgement.judging import EVERYTHING, Remainder, depends_on
from gimbal_hil.knowledge.discrepancy.twin import Floats
from sim_backend.effects import Variable

_ROWS = 6000


def _record(seed: int) -> Any:
    """Ten seconds of two axes whose every signal is noise of a second's memory."""
    rng = np.random.default_rng(seed)

    def slow(columns: int) -> Floats:
        steps = rng.standard_normal((_ROWS, columns))
        return np.asarray(np.apply_along_axis(lambda one: np.convolve(one, np.ones(50) / 7.0, "same"), 0, steps))

    bands = SimpleNamespace(period_s=10.0 / _ROWS)
    signals = dict(motion=slow(6), torque=slow(2), heat=slow(2), base=slow(9))
    return SimpleNamespace(**signals, bands=bands, name="", at_scored=lambda column: column)


def _left(record: Any, of: str) -> Floats:
    noise = 0.3 * np.random.default_rng(9).standard_normal(_ROWS)
    return np.asarray({"other torque": record.torque[:, 1], "nothing": 0.0 * noise}[of] + noise)


@pytest.mark.parametrize(
    ("of", "variables", "predicted"),
    [
        ("other torque", EVERYTHING, True),
        ("other torque", EVERYTHING - {Variable.OTHER_TORQUE}, False),
        ("other torque", frozenset({Variable.TORQUE}), False),
        ("nothing", EVERYTHING, False),
    ],
)
def test_what_the_other_axis_is_commanded_is_asked_too(
    of: str, variables: frozenset[Variable], predicted: bool
) -> None:
    taught, asked = _record(1), _record(2)
    hypothesis = SimpleNamespace(origins=())
    twins = [
        SimpleNamespace(
            records=(record,),
            model=SimpleNamespace(axes=("outer", "inner")),
            channels=(SimpleNamespace(axis="outer", signal="torque"),),
        )
        for record in (taught, asked)
    ]
    state: Any = SimpleNamespace(hypothesis=hypothesis, held=hypothesis, fitted=_left(taught, of)[:, None])
    inquiry: Any = SimpleNamespace(twin=twins[0], holdout=twins[1], in_order=lambda _: _left(asked, of)[:, None])
    found = exhaustion.predictable(inquiry, state, 0, variables).beyond
    assert (found > 0.7) if predicted else (found < 0.1)


@pytest.mark.parametrize(
    ("alone", "together", "said"),
    [
        ({}, 0.6, None),
        ({Variable.RATE: 0.3}, 0.6, None),
        ({Variable.RATE: 0.5, Variable.TORQUE: 0.51}, 0.6, (Variable.RATE, 0.5)),
        ({Variable.RATE: 0.5, Variable.TORQUE: 0.58}, 0.6, (Variable.TORQUE, 0.58)),
        ({Variable.TIME: 0.1}, 0.1, None),
        # where each log goes one way, its place and its torque say which
        (
            {Variable.DIRECTION: 0.55, Variable.POSITION: 0.56, Variable.TORQUE: 0.57},
            0.6,
            (Variable.DIRECTION, 0.55),
        ),
        # on a base that stands, what goes with it is the joint's own motion; and nobody read a temperature
        ({Variable.BASE_MOTION: 0.6, Variable.TEMPERATURE: 0.6, Variable.PAST: 0.55}, 0.6, (Variable.PAST, 0.55)),
    ],
)
def test_a_gap_depends_on_the_variable_that_alone_says_nearly_as_much_as_all(
    monkeypatch: pytest.MonkeyPatch,
    alone: dict[Variable, float],
    together: float,
    said: tuple[Variable, float] | None,
) -> None:
    def share(inquiry: Any, state: Any, column: int, variables: frozenset[Variable]) -> Predictable:
        (one,) = variables
        return Predictable(alone.get(one, 0.0), 0.0)

    monkeypatch.setattr(judging, "predictable", share)
    twin = SimpleNamespace(records=(SimpleNamespace(moving_base=False, has_temperature=False),))
    inquiry: Any = SimpleNamespace(policy=Policy(), twin=twin, holdout=twin)
    left = (Remainder(1.0, 1.0, Predictable(0.0, 0.0)), Remainder(5.0, 5.0, Predictable(together, 0.0)))
    state: Any = None
    assert depends_on(inquiry, state, left) == said


def test_the_direction_alone_predicts_what_a_log_of_each_way_leaves_and_nothing_that_changes_along_it() -> None:
    def one_way(sign: float) -> Any:
        record = _record(5)
        way = np.linspace(0.0, sign, _ROWS)
        motion = np.column_stack([way, record.motion[:, 1], np.full(_ROWS, sign), *record.motion[:, 3:].T])
        return SimpleNamespace(**{**vars(record), "motion": motion})

    both = tuple(one_way(sign) for sign in (1.0, -1.0))
    place = np.concatenate([record.motion[:, 0] for record in both])
    twin = SimpleNamespace(
        records=both,
        model=SimpleNamespace(axes=("outer", "inner")),
        channels=(SimpleNamespace(axis="outer", signal="torque"),),
    )
    hypothesis = SimpleNamespace(origins=())
    found = []
    for left in (np.sign(place), np.sin(40.0 * place)):
        state: Any = SimpleNamespace(hypothesis=hypothesis, held=hypothesis, fitted=left[:, None])
        inquiry: Any = SimpleNamespace(twin=twin, holdout=twin, in_order=lambda s: s.fitted)
        found.append(exhaustion.predictable(inquiry, state, 0, frozenset({Variable.DIRECTION})).share)
    assert found[0] > 0.95 and found[1] < 0.1
