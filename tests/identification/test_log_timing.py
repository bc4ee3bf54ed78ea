"""Torque columns that are early or late are told, whatever friction the joint has; others are not."""

from __future__ import annotations

import numpy as np
import pytest
import yaml

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.identification import shifted_torques
from sim_backend.model import AntennaModel, load_model
from tests.identification.one_axis_rig import ENCODER_STEP, Rig, apply_torque, reversing_multisine


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> AntennaModel:
    axis = {"body": {"mass": 1.0, "inertia": {"zz": 0.5}}, "encoder": {"step": ENCODER_STEP}}
    path = tmp_path_factory.mktemp("timing") / "arm.yaml"
    path.write_text(yaml.safe_dump({"schema": 1, "name": "arm", "kind": "rotary", "axes": {"arm": axis}}))
    return load_model(path)


def log(rows: int, seconds: float = 20.0) -> SignalsTable:
    """A joint with bristles, its torque column `rows` late."""
    found = apply_torque(Rig(), reversing_multisine(1.0, seconds, 1))
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


def test_a_stated_time_and_a_log_that_is_too_short_are_not_asked(model: AntennaModel) -> None:
    assert shifted_torques(model, (log(4),), frozenset({"arm"})) == ()
    assert shifted_torques(model, (log(4, 0.3),)) == () and shifted_torques(model, ()) == ()
