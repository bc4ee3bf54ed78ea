"""A drive at its limit is nothing wrong; a column that was cut off below it is, and so is one in another unit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.preflight import preflight
from gimbal_hil.data.preflight.held_torque import held_torques
from gimbal_hil.data.signals import SignalsTable
from sim_backend.model import AntennaModel, model_from_document

LIMIT, INERTIA, COULOMB, VISCOUS, RATE_HZ = 0.3, 0.02, 0.03, 0.01, 500.0


def joint() -> AntennaModel:
    axis = {
        "body": {"mass": 1.0, "inertia": {"zz": INERTIA}},
        "friction": {"coulomb": COULOMB, "breakaway": COULOMB, "viscous": VISCOUS},
        "encoder": {"step": 1e-5},
        "actuator": {"limit": LIMIT},
    }
    return model_from_document({"schema": 1, "name": "arm", "kind": "rotary", "axes": {"pan": axis}}, "arm")


def swung(gain: float) -> tuple[SignalsTable, SignalsTable]:
    """The torque that a loop gave and the one that it asked for, which its drive limits in a part of the rows."""
    fine, q, v = 10, 0.0, 0.0
    given, asked, position = [], [], []
    for k in range(int(12.0 * RATE_HZ)):
        t = k / RATE_HZ
        wanted = gain * (np.sin(2.6 * t) + 0.4 * np.sin(7.1 * t) - q) - 0.25 * v
        asked.append(wanted)
        given.append(float(np.clip(wanted, -LIMIT, LIMIT)))
        position.append(1e-5 * round(q / 1e-5))
        for _ in range(fine):
            v += (given[-1] - COULOMB * np.tanh(v / 0.01) - VISCOUS * v) / INERTIA / RATE_HZ / fine
            q += v / RATE_HZ / fine
    time = np.arange(len(given)) / RATE_HZ
    tables = (
        SignalsTable.of(("pan",), time, {"pan.torque": np.array(torque), "pan.position": np.array(position)})
        for torque in (given, asked)
    )
    return next(tables), next(tables)


def test_a_drive_at_its_own_limit_is_no_rail_and_a_column_cut_off_below_it_is() -> None:
    given, _ = swung(1.4)
    assert 0.1 < np.mean(np.abs(given.torque("pan")) == LIMIT) < 0.6
    assert list(held_torques(joint(), given, "pan")) == []
    columns = {**given.columns, "pan.torque": np.clip(given.columns["pan.torque"], -0.6 * LIMIT, 0.6 * LIMIT)}
    (found,) = held_torques(joint(), replace(given, columns=columns), "pan")
    assert "end of the column's range" in found.what


def test_a_loop_that_asks_for_more_than_there_is_is_read_and_another_unit_is_refused() -> None:
    _, asked = swung(8.0)
    assert np.mean(np.abs(asked.torque("pan")) > LIMIT) > 0.5
    preflight(joint(), (asked,))
    columns = {**asked.columns, "pan.torque": 1e6 * asked.columns["pan.torque"]}
    with pytest.raises(BadInputError, match=r"pan\.torque"):
        preflight(joint(), (replace(asked, columns=columns),))
