"""What is asked whether it predicts a remainder: the variables of an axis, their past, and what is beside it."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gimbal_hil.discrepancy.judgement import exhaustion
from gimbal_hil.discrepancy.judgement.judging import EVERYTHING, _own_variables
from gimbal_hil.discrepancy.twin import Floats
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
    found = _predicted(lambda record: _left(record, of), variables)
    assert (found > 0.7) if predicted else (found < 0.1)


@pytest.mark.parametrize(("orders", "predicted"), [((219.0,), True), ((), False), ((240.0,), False)])
def test_of_a_ripple_its_own_waves_are_asked(orders: tuple[float, ...], predicted: bool) -> None:
    def left(record: Any) -> Floats:
        position, rate = record.motion[:, 0], record.motion[:, 2]
        return np.asarray(np.sin(219.0 * position + 0.3) * rate**2)

    found = _predicted(left, frozenset({Variable.POSITION, Variable.RATE}), orders)
    assert (found > 0.9) if predicted else (found < 0.1)


@pytest.mark.parametrize(("variables", "predicted"), [({Variable.RATE, Variable.TIME}, True), ({Variable.RATE}, False)])
def test_what_a_cause_does_it_does_at_any_time(variables: set[Variable], predicted: bool) -> None:
    first_half = np.arange(_ROWS) < _ROWS // 2
    found = _predicted(lambda record: record.motion[:, 2] * np.where(first_half, -1.0, 1.0), frozenset(variables))
    assert (found > 0.7) if predicted else (found < 0.1)
    assert Variable.TIME in _own_variables("viscous") and Variable.PAST not in _own_variables("backlash")


def _predicted(left: Callable[[Any], Floats], variables: frozenset[Variable], orders: tuple[float, ...] = ()) -> float:
    """Share of what is left of one record that is predicted from what is left of another one."""
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
    state: Any = SimpleNamespace(hypothesis=hypothesis, held=hypothesis, fitted=left(taught)[:, None])
    inquiry: Any = SimpleNamespace(twin=twins[0], holdout=twins[1], in_order=lambda _: left(asked)[:, None])
    return exhaustion.predictable(inquiry, state, 0, variables, orders).beyond
