"""Where nothing in a log says how large its torque is, the answer says so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.identification.estimate import Determination, Estimate, Interval
from gimbal_hil.knowledge.identification.rigid_load import axis_load
from gimbal_hil.knowledge.identification.torque_scale import scale_findings, without_doubted
from sim_backend.model import AntennaModel, load_model
from tests.cases.joint import MODEL, swinging


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> AntennaModel:
    path = tmp_path_factory.mktemp("scale") / "model.yaml"
    path.write_text(MODEL)
    return load_model(path)


def table(**more: np.ndarray) -> SignalsTable:
    log = swinging(seconds=4.0)
    columns = {"joint.torque": log.torque, "joint.position": log.position, **more}
    return SignalsTable.of(("joint",), log.time, columns, None, "log.csv")


def estimate(name: str, value: float) -> Estimate:
    return Estimate(name, value, Interval(0.99 * value, 1.01 * value), "", Determination.IDENTIFIED, value)


def told(model: AntennaModel, one: SignalsTable, *estimates: Estimate) -> list[str]:
    found = scale_findings(axis_load(one, model, "joint"), one, model, "joint", estimates)
    return [finding.text for finding in found]


def test_numbers_that_are_off_by_one_factor_say_that_the_torque_may_be(model: AntennaModel) -> None:
    (text,) = told(model, table(), estimate("coulomb", 0.0707), estimate("inertia", 0.02828))
    assert "coulomb and inertia would be wrong by the factor" in text and "1.41 times the model's 0.02" in text


def test_the_inertia_of_the_model_vouches_for_the_torque(model: AntennaModel) -> None:
    assert told(model, table(), estimate("coulomb", 0.0707), estimate("inertia", 0.0201)) == []


def test_friction_alone_says_nothing_of_the_torque(model: AntennaModel) -> None:
    (text,) = told(model, table(), estimate("coulomb", 0.05))
    assert "says how large its torque is" in text


def test_a_torque_that_is_known_tells_it_and_without_numbers_nothing_is_said(model: AntennaModel) -> None:
    known = 0.3 * np.sin(swinging(seconds=4.0).position)
    assert told(model, table(**{"joint.torque_known": known}), estimate("inertia", 0.03)) == []
    unknown = replace(estimate("inertia", 0.03), verdict=Determination.NOT_IDENTIFIED)
    assert told(model, table(), unknown) == []


def test_an_inertia_that_is_two_pi_times_the_models_is_told_as_a_position_in_turns(model: AntennaModel) -> None:
    (text,) = told(model, table(), estimate("coulomb", 0.05), estimate("inertia", 0.1243))
    assert "about 2 pi" in text and "--column joint.position=COLUMN:turn" in text


def test_nothing_that_a_position_in_turns_makes_wrong_is_called_identified(model: AntennaModel) -> None:
    viscous = replace(estimate("viscous", 0.1287), unit="N m s/rad")
    both = (replace(estimate("coulomb", 0.05), unit="N m"), viscous)
    known = (*both, replace(estimate("inertia", 0.1243), unit="kg m2"))
    one = table()
    found = scale_findings(axis_load(one, model, "joint"), one, model, "joint", known)
    assert found[0].concerns == {"viscous", "inertia"}
    verdicts = [e.verdict is Determination.IDENTIFIED for e in without_doubted(known, found)]
    assert verdicts == [True, False, False] and without_doubted(known, ()) == known
