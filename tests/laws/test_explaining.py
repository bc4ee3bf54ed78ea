"""Whether laws explain what was there."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, Policy, State
from gimbal_hil.knowledge.discrepancy.judgement import beyond_noise, deciding
from gimbal_hil.knowledge.discrepancy.laws import finding
from gimbal_hil.knowledge.discrepancy.laws.finding import Described, _best, _better, _explains
from gimbal_hil.knowledge.discrepancy.laws.linear import Straight
from gimbal_hil.knowledge.discrepancy.twin import TORQUE, Channel

AXES = ("outer", "inner")


def left(*floors: float) -> State:
    """A state that leaves so many floors of each channel."""
    return cast(State, SimpleNamespace(untouched=np.tile(floors, (4, 1))))


def laws_of(after: State, *axes: str) -> Described:
    """Laws of some axes that leave a state."""
    twin = SimpleNamespace(channels=[Channel(axis, TORQUE, i) for i, axis in enumerate(AXES)])
    laws = [SimpleNamespace(curve=SimpleNamespace(shape=SimpleNamespace(axis=axis))) for axis in axes]
    inquiry = SimpleNamespace(policy=Policy(), twin=twin)
    return cast(Described, SimpleNamespace(laws=laws, inquiry=inquiry, state=after))


@pytest.mark.parametrize(
    ("before", "after", "axes", "explains"),
    [
        # a cube that leaves 1.05 of 47 floors beside 1.51 floors of the other axis, which it does not act on
        ((1.512, 46.5), (1.513, 1.05), ("inner",), True),
        ((5.0, 46.5), (5.0, 1.05), ("inner",), True),
        # more of the other axis than before, or what is left of its own
        ((1.512, 46.5), (2.0, 1.05), ("inner",), False),
        ((1.0, 46.5), (1.0, 20.0), ("inner",), False),
        ((1.0, 46.5), (1.0, 4.0), ("inner",), True),
        # of two laws both have to
        ((5.0, 46.5), (4.0, 1.05), AXES, False),
        ((5.0, 46.5), (1.3, 1.05), AXES, True),
        # a half without a gap where a law acts judges nothing
        ((5.0, 1.2), (5.0, 1.0), ("inner",), False),
    ],
)
def test_laws_explain_the_channels_that_they_act_on_and_leave_no_more_of_the_others(
    before: tuple[float, float], after: tuple[float, float], axes: tuple[str, ...], explains: bool
) -> None:
    assert _explains(left(*before), laws_of(left(*after), *axes)) is explains


@pytest.mark.parametrize(
    ("left_floors", "beside_wander", "lacks"),
    [
        # a torque over position that friction whose level wanders would leave just as well: the verdict calls it noise
        ((2.79, 0.7), (1.34, 0.88), (False, False)),
        # what wander leaves of one axis is no reason for a law of the other
        ((4.66, 3.45), (1.3, 3.4), (False, True)),
        ((46.5, 1.512), (46.0, 1.51), (True, False)),
        # no gap, whatever wander would leave of a single log
        ((1.2, 1.4), (2.1, 2.1), (False, False)),
    ],
)
def test_laws_are_looked_for_only_where_more_is_left_than_friction_that_wanders(
    left_floors: tuple[float, float],
    beside_wander: tuple[float, float],
    lacks: tuple[bool, bool],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rows, looked = np.tile(left_floors, (4, 1)), []
    null = cast(State, SimpleNamespace(fitted=rows, left=lambda: np.array(left_floors)))
    inquiry = SimpleNamespace(
        policy=Policy(),
        selecting=np.array([True, True, False, False]),
        inexact=0.0,
        in_order=lambda state: rows,
        tell=looked.append,
        twin=SimpleNamespace(
            channels=[Channel(axis, TORQUE, i) for i, axis in enumerate(AXES)], model=None, records=()
        ),
    )
    monkeypatch.setattr(deciding, "left_beside_wander", lambda *_: np.array(beside_wander))
    monkeypatch.setattr(finding, "shapes_of", lambda *_: ())
    lacking = beyond_noise(cast(Inquiry, inquiry), null)
    assert tuple(lacking) == lacks
    found = cast(Described, SimpleNamespace(inquiry=inquiry, state=null))
    assert list(_best(null, lacking, found, cast(Straight, None))) == []
    assert looked == [f"looking for a law of {axis}" for axis, one in zip(AXES, lacks, strict=True) if one]


@pytest.mark.parametrize(
    ("named", "laws", "better"),
    [
        # a saturation that is named leaves the floor, and so does a curve that draws the same
        (0.974, 0.969, False),
        (1.0, 0.9, False),
        (3.0, 1.0, True),
        (3.0, 2.0, False),
    ],
)
def test_a_law_beside_names_that_leave_the_floor_is_no_better(
    named: float, laws: float, better: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(finding, "surely_less", lambda *_: 1.0)
    one, other = (
        cast(State, SimpleNamespace(fitted=np.full((4, 1), floors), left=lambda floors=floors: np.array([floors])))
        for floors in (named, laws)
    )
    assert _better(cast(Inquiry, SimpleNamespace(policy=Policy())), one, other) is better
