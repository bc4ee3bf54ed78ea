"""Commanded torque alone cannot tell a motor's back-EMF from drag in the joint; torque measured at the actuator can."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.discrepancy import Request, diagnose, verdict_of
from gimbal_hil.experiments.sequences import SequenceOptions
from gimbal_hil.experiments.sequences.survey import survey_motion
from gimbal_hil.improvement.rehearsal import rehearse
from gimbal_hil.settings import shipped_settings
from gimbal_hil.signals import SignalsTable
from sim_backend.model import AntennaModel, shipped_model

COEFFICIENT = 0.06


def measured(antenna: AntennaModel, number: int, back_emf: float) -> SignalsTable:
    """A survey of an antenna with the torque that its inner actuator gave, read with noise at the end of each row."""
    table = rehearse(
        survey_motion(SequenceOptions(1000.0, short=True), number), shipped_settings(), antenna, seed=20 + number
    ).table
    assert table is not None
    rate = np.gradient(table.position("inner")) / table.period_s
    given = table.torque("inner") - back_emf * rate
    noise = 0.01 * np.random.default_rng(number).standard_normal(len(table))
    columns = dict(table.columns) | {"inner.torque_measured": given + noise}
    return SignalsTable.of(table.axes, table.time_s, columns, source=f"survey {number}")


@pytest.mark.heavy
@pytest.mark.parametrize("hidden", ["back_emf", "viscous"])
def test_the_measured_torque_tells_back_emf_from_drag(hidden: str) -> None:
    start = shipped_model()
    in_joint = {"viscous": start.number("inner", "friction.viscous") + COEFFICIENT}
    antenna = start.with_effect(hidden, "inner", {"coefficient": COEFFICIENT} if hidden == "back_emf" else in_joint)
    tables = [measured(antenna, number, COEFFICIENT if hidden == "back_emf" else 0.0) for number in (0, 1)]
    verdict = verdict_of(diagnose(Request(start, (tables[0],), (tables[1],)))).document
    assert verdict["verdict"] == "named"
    assert [(e["name"], e["axis"]) for e in verdict["effects"]] == [(hidden, "inner")]
    assert not verdict["alternatives"]
