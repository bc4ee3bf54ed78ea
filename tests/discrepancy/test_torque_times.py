"""Torque columns that are early or late are told, whatever friction the joint has; others are not."""

from __future__ import annotations

import re

import numpy as np
import pytest

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.verdict.torque_times import shifted_torques
from sim_backend.model import AntennaModel, model_from_document
from tests.identification.one_axis_rig import ENCODER_STEP, OUTER, Rig, apply_torque, reversing_multisine


def stating(**friction: float) -> AntennaModel:
    """The joint with this friction stated."""
    axis = {"body": {"mass": 1.0, "inertia": {"zz": 0.5}}, "friction": friction, "encoder": {"step": ENCODER_STEP}}
    return model_from_document({"schema": 1, "name": "arm", "kind": "rotary", "axes": {"arm": axis}}, "arm")


@pytest.fixture(scope="module")
def model() -> AntennaModel:
    return stating()


def log(rows: int, seconds: float = 20.0, amplitude_nm: float = 1.0) -> SignalsTable:
    """A joint with bristles, its torque column `rows` late."""
    found = apply_torque(Rig(), reversing_multisine(amplitude_nm, seconds, 1))
    late = np.roll(found.torque, rows)
    return SignalsTable.of(
        ("arm",), found.time_s, {"arm.torque": late, "arm.position": found.position}, None, "arm.csv"
    )


def test_a_torque_in_time_is_not_said_to_be_late_whatever_bristles_make_of_reversals(model: AntennaModel) -> None:
    assert shifted_torques(model, (log(0),)) == ()


@pytest.mark.parametrize(("rows", "word", "cause"), [(4, "late", "so it is the log"), (-4, "early", "a delay of the")])
def test_a_torque_column_of_another_time_is_told_with_what_else_it_may_be(
    model: AntennaModel, rows: int, word: str, cause: str
) -> None:
    (found,) = shifted_torques(model, (log(rows),))
    assert (found.rule, found.axis) == ("torque_shifted", "arm")
    assert word in found.text and cause in found.text


@pytest.mark.parametrize("times", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("rows", [-2, 0, 2])
def test_bristles_that_the_model_states_are_no_shift_whatever_numbers_are_wrong(times: float, rows: int) -> None:
    level, bristle = OUTER.static, {"sigma0": OUTER.sigma0, "sigma1": OUTER.sigma1}
    wrong = {name: times * getattr(level, name) for name in ("coulomb", "breakaway", "viscous")}
    shape = {"stribeck_velocity": level.stribeck_velocity, "shape": level.shape}
    found = shifted_torques(stating(**wrong, **shape, **bristle), (log(rows, amplitude_nm=4.0),))
    assert [one.rule for one in found] == (["torque_shifted"] if rows else [])
    if found:
        said = re.search(r"is ([0-9.]+) ms .* (late|early) against", found[0].text)
        assert said is not None and float(said[1]) == pytest.approx(2.0, abs=0.15)
        assert said[2] == ("late" if rows > 0 else "early")


def test_a_stated_time_and_a_log_that_is_too_short_are_not_asked(model: AntennaModel) -> None:
    assert shifted_torques(model, (log(4),), frozenset({"arm"})) == ()
    assert shifted_torques(model, (log(4, 0.3),)) == () and shifted_torques(model, ()) == ()


def test_logs_that_contradict_one_another_say_nothing_of_the_torque_columns_time(model: AntennaModel) -> None:
    assert shifted_torques(model, (log(4), log(4, 15.0)))
    assert shifted_torques(model, (log(4), log(-4, 15.0))) == shifted_torques(model, (log(4), log(0, 15.0))) == ()


def test_a_shift_of_more_than_was_sought_says_nothing_of_the_torque_columns_time(model: AntennaModel) -> None:
    assert shifted_torques(model, (log(300),)) == ()
