"""Intervals of what is told: of a number that moves as a cause and as a known number both, and of strengths."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy.hypotheses import Cause, values_of
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, Policy, State, refitted, settled
from gimbal_hil.knowledge.discrepancy.inquiry.prepare import as_stated, effect_names, prepared, recalibrated
from gimbal_hil.knowledge.discrepancy.judgement.intervals import number_intervals, parameter_intervals, strength_error
from gimbal_hil.knowledge.executor import open_executor
from sim_backend.model import AntennaModel, model_from_document
from tests.discrepancy.test_logs_of_strangers import COULOMB, INERTIA, STEP, swing, table

_STATED = 10.0


def _arm(wrong: float, bent: float | None = None) -> AntennaModel:
    """One joint whose numbers are known to 10 %, of which the dry friction is stated wrong by a factor; that its
    bristles bend so far (rad), which is known to 50 %, is assumed where it is given.
    """
    level = COULOMB * wrong
    assumed = {"uncertainty": "50%", "source": "assumed"}
    bristles = {} if bent is None else {"sigma0": {"value": level / bent, "unit": "N m/rad", **assumed}}
    axis = {
        "body": {"mass": 1.0, "inertia": {"zz": INERTIA}},
        "friction": {"coulomb": level, "breakaway": level, "viscous": 0.001, **bristles},
        "encoder": {"step": STEP},
    }
    document = {"schema": 1, "name": "arm", "kind": "rotary", "incline_sine": 0.0, "uncertainty": f"{_STATED}%"}
    return model_from_document(document | {"axes": {"pan": axis}}, "arm")


@contextmanager
def _with(*effects: str, wrong: float, bent: float | None = None) -> Iterator[tuple[Inquiry, State]]:
    """Two logs of the arm, and these effects fitted to them beside the known numbers."""
    logs = []
    for seed, speed in enumerate((1.0, 0.8)):
        t, torque, position = swing(10.0, noise=0.003, speed=speed)
        torque = torque + 0.002 * np.random.default_rng(seed).standard_normal(len(torque))
        logs.append(table({"pan.torque": torque, "pan.position": position}, t))
    with open_executor(1, None) as executor:
        names = effect_names(effects, ())
        inquiry, _ = prepared(
            _arm(wrong, bent), tuple(logs[:1]), tuple(logs[1:]), None, names, Policy(), executor, lambda text: None
        )
        inquiry, state = recalibrated(inquiry, as_stated(inquiry))
        for effect in effects:
            family = next(family for family in inquiry.families if family.effect == effect)
            cause = Cause(family, (0.0,) * len(family.knobs))
            state = settled(inquiry, refitted(inquiry, state, state.hypothesis.plus(cause)))
        yield inquiry, state


@pytest.mark.parametrize("wrong", [1.5, 0.7])
def test_a_number_that_is_a_cause_is_known_as_well_as_data_tell_it(wrong: float) -> None:
    # it also floats within its 10 %: either alone is as unsure as that, both together are not
    with _with("coulomb", wrong=wrong) as (inquiry, state):
        value, _ = values_of(inquiry.twin.model, inquiry.twin, state.hypothesis, 0)["coulomb"]
        low, high = parameter_intervals(inquiry, state, 0)["coulomb"]
    assert low < COULOMB < high and low < value < high
    assert high - low < 0.05 * COULOMB


def test_a_strength_that_data_hardly_tell_is_known_to_more_than_itself() -> None:
    # an offset that is not there beside a friction that is: the one has a strength, the other has none
    with _with("coulomb", "torque_offset", wrong=1.5) as (inquiry, state):
        friction, offset = (strength_error(inquiry, state, i) for i in range(2))
    assert friction < 0.05 and offset > 0.5


def test_a_known_number_at_the_end_of_its_uncertainty_may_be_beyond_it() -> None:
    with _with(wrong=1.5) as (inquiry, state):
        paths = [known.path for known in state.hypothesis.floating]
        at = paths.index("friction.coulomb")
        assert at in state.hypothesis.pressing
        low, high = number_intervals(inquiry, state)[at]
    # of its logarithm: what the model says of it ends nowhere sharply
    assert low < -1.3 * _STATED / 100.0
    assert high < 0.0


def test_what_goes_with_a_number_that_presses_against_what_is_assumed_of_it_may_go_on_too() -> None:
    # the joint has no bristles, and the model ones that bend far: at the end of what is said of them the level is low
    with _with("coulomb", wrong=0.8, bent=0.01) as (inquiry, state):
        assert [state.hypothesis.floating[i].path for i in state.hypothesis.pressing] == ["friction.sigma0"]
        low, high = parameter_intervals(inquiry, state, 0)["coulomb"]
    assert low < COULOMB < high
