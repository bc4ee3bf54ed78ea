"""What a twin takes from an earlier evaluation is what it would have computed, to the bit, whatever changed between
them.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.hypotheses.evidence import families
from gimbal_hil.knowledge.discrepancy.hypotheses.families import Family
from gimbal_hil.knowledge.discrepancy.hypotheses.hypothesis import Cause, Hypothesis, known_numbers, parameters_of
from gimbal_hil.knowledge.discrepancy.twin.record import Record, record_of
from gimbal_hil.knowledge.discrepancy.twin.twin import Twin
from sim_backend.effects import CATALOGUE
from sim_backend.model import shipped_model

MODEL = shipped_model()


def moving_log() -> SignalsTable:
    """Three seconds in which both axes and the base move, gyros included."""
    t = np.arange(3000) * 1e-3
    columns = {"base.p": 0.2 * np.cos(2.0 * t), "base.roll": 0.1 * np.sin(2.0 * t)}
    for axis, (size, rate) in zip(MODEL.axes, ((0.4, 1.1), (0.3, 1.9)), strict=True):
        columns |= {
            f"{axis}.position": size * np.sin(rate * t) + 0.01 * np.sin(14.0 * t),
            f"{axis}.rate": size * rate * np.cos(rate * t) + 0.14 * np.cos(14.0 * t),
            f"{axis}.torque": 0.8 * np.sign(np.cos(rate * t)) + 0.1 * np.sin(40.0 * t),
        }
    return SignalsTable.of(MODEL.axes, t, columns)


RECORD: Record = record_of(moving_log(), MODEL, 25.0, "log")
FAMILIES = {f.label: f for axis in MODEL.axes for f in families(Twin(MODEL, (RECORD,)), axis)}
SHARES = st.floats(0.0, 1.0)


@st.composite
def hypotheses(draw: st.DrawFn) -> Hypothesis:
    """Up to three causes anywhere inside their bounds, and known numbers that have moved."""
    causes = []
    for label in draw(st.lists(st.sampled_from(sorted(FAMILIES)), max_size=3, unique=True)):
        family: Family = FAMILIES[label]
        at = [draw(SHARES) for _ in family.knobs]
        reach = [(max(knob.low, -1.0), min(knob.high, 1.0)) for knob in family.knobs]
        causes.append(
            Cause(family, tuple(low + share * (high - low) for share, (low, high) in zip(at, reach, strict=True)))
        )
    floating = known_numbers(MODEL)
    moved = draw(st.sets(st.integers(0, len(floating) - 1), max_size=2))
    return Hypothesis(tuple(causes), floating, tuple(1e-3 if i in moved else 0.0 for i in range(len(floating))))


@pytest.mark.parametrize("label", sorted(FAMILIES))
def test_every_effect_changes_no_more_than_the_parts_that_are_evaluated_anew(label: tuple[str, str]) -> None:
    neutral, family = Hypothesis(), FAMILIES[label]
    nudged = tuple(0.3 * (min(k.high, 1.0) - max(k.low, -1.0)) + max(k.low, -1.0) for k in family.knobs)
    evaluated_alike([neutral, neutral.plus(Cause(family, nudged)), neutral])


@pytest.mark.heavy
@settings(max_examples=60, deadline=None)
@given(st.lists(hypotheses(), min_size=2, max_size=7))
def test_evaluations_in_any_order_are_those_of_a_fresh_twin(asked: list[Hypothesis]) -> None:
    evaluated_alike(asked)


def evaluated_alike(asked: list[Hypothesis]) -> None:
    twin = Twin(MODEL, (RECORD,))
    for hypothesis in asked:
        fresh = Twin(MODEL, (RECORD,))
        for record in (0, 1):
            seen, expected = (
                one.evaluated(*parameters_of(one, hypothesis), one.records[0] if record == 0 else one.dithered(0))
                for one in (twin, fresh)
            )
            np.testing.assert_array_equal(seen.rows, expected.rows)
            np.testing.assert_array_equal(twin.thinned(seen), fresh.thinned(expected))


def test_a_number_of_one_joint_leaves_the_other_joint_as_it_was() -> None:
    twin = Twin(MODEL, (RECORD,))
    outer = next(f for (name, axis), f in FAMILIES.items() if name == "viscous" and axis == MODEL.axes[0])
    before = twin.evaluated(*parameters_of(twin, Hypothesis()), RECORD)
    after = twin.evaluated(*parameters_of(twin, Hypothesis((Cause(outer, (0.2,)),))), RECORD)
    assert not np.array_equal(before.rows[0], after.rows[0])
    np.testing.assert_array_equal(before.rows[1:4], after.rows[1:4])
    assert CATALOGUE["viscous"].is_number


def test_which_effects_keep_a_change_of_the_command_from_the_joint_is_measured() -> None:
    cut = {effect for (effect, _), family in FAMILIES.items() if family.cuts_command}
    assert cut == {
        "actuator_lag",
        "backlash",
        "load_dependent_friction",
        "saturation",
        "torque_gain",
        "transport_delay",
    }
    assert not Twin(MODEL, (RECORD,)).cuts_command
