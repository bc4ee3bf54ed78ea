"""A motion has the energy that torque and weight gave it: times in minutes are found by that, wrong models are not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.preflight import preflight
from gimbal_hil.data.preflight.energy import impossible_energy
from gimbal_hil.data.signals import SignalsTable
from sim_backend.model import AntennaModel, load_model, shipped_model
from tests.blind.cases import tables_of
from tests.blind.draw import draw
from tests.cases.joint import MODEL, JointLog, swinging

LOG = swinging()


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> AntennaModel:
    path = tmp_path_factory.mktemp("energy") / "model.yaml"
    path.write_text(MODEL)
    return load_model(path)


def table(log: JointLog = LOG, time: float = 1.0) -> SignalsTable:
    columns = {"joint.torque": log.torque, "joint.position": log.position}
    return SignalsTable.of(("joint",), time * log.time, columns, None, "log.csv")


@pytest.mark.parametrize(("factor", "unit"), [(60.0, "minutes"), (3600.0, "hours"), (86_400.0, "days")])
def test_times_in_a_longer_unit_are_refused_by_its_name(model: AntennaModel, factor: float, unit: str) -> None:
    with pytest.raises(BadInputError, match=rf"log.csv: time_s: seems to be in {unit}: up to row \d+ .* J.*:UNIT"):
        preflight(model, (table(time=1.0 / factor),))


def test_an_energy_that_no_unit_of_time_explains_names_all_columns(model: AntennaModel) -> None:
    weak = table(LOG.but(torque=1e-7 * LOG.torque, position=1e3 * LOG.position))
    found = impossible_energy(model, weak)
    assert found is not None and found.gained > 100.0 * found.given


@settings(max_examples=25, deadline=None)
@given(factor=st.floats(1.0 / 30.0, 30.0), seed=st.integers(0, 99))
def test_a_model_that_is_off_by_a_factor_is_no_reason(model: AntennaModel, factor: float, seed: int) -> None:
    off = model.with_numbers("joint", {"body.inertia.zz": 0.02 * factor})
    assert impossible_energy(off, table(swinging("ab"[seed % 2], 6.0, seed=seed))) is None


#: sound logs
SOUND: dict[str, Callable[[], JointLog]] = {
    "swinging": lambda: LOG,
    "cogging": lambda: swinging(cogging=0.1),
    "torque late": lambda: LOG.but(torque=np.roll(LOG.torque, 10)),
    "coasting": lambda: LOG.but(torque=0.0 * LOG.torque + 1e-3, position=0.3 * LOG.time + 1e-4 * np.sin(LOG.time)),
}


@pytest.mark.parametrize("case", SOUND)
def test_a_sound_log_is_not_asked_about_its_energy(model: AntennaModel, case: str) -> None:
    assert impossible_energy(model, table(SOUND[case]())) is None


def test_an_antenna_on_a_moving_base_has_the_energy_it_may_have() -> None:
    case = draw(seed=20003, names=[])
    assert all(impossible_energy(shipped_model(), one) is None for one in tables_of(case.measured, case.axes))
