"""A ripple in logs whose positions lie many turns from zero, as an encoder that counts turns makes them."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy import Request, diagnose, verdict_of
from sim_backend.model import AntennaModel, model_from_document
from tests.cases.joint import BENCH, JointLog
from tests.discrepancy.test_logs_of_strangers import table

AMPLITUDE_NM, ORDER, PHASE_RAD = 0.02, 7.0, 0.4


def joint_model() -> AntennaModel:
    axis = {
        "body": {"inertia": {"zz": BENCH.inertia}},
        "friction": {"coulomb": BENCH.coulomb, "breakaway": BENCH.coulomb, "viscous": BENCH.viscous},
        "encoder": {"step": BENCH.step},
    }
    return model_from_document({"schema": 1, "name": "joint", "kind": "rotary", "axes": {"pan": axis}}, "joint")


@pytest.mark.parametrize(
    "turns", [pytest.param(0, marks=pytest.mark.heavy), 8, pytest.param(-32, marks=pytest.mark.heavy)]
)
def test_a_ripple_is_named_with_its_phase_at_zero_wherever_the_travel_is(turns: int) -> None:
    far = 2.0 * np.pi * turns + 0.3
    logs = [BENCH.log(which, seconds=12.0, cogging=AMPLITUDE_NM, seed=3 + k) for k, which in enumerate("ab")]

    def read(log: JointLog) -> object:
        return table({"pan.torque": log.torque, "pan.position": log.position + far}, log.time)

    measured, holdout = (read(log) for log in logs)
    found = verdict_of(diagnose(Request(joint_model(), (measured,), (holdout,)))).document  # type: ignore[arg-type]
    assert found["verdict"] == "named" and [one["name"] for one in found["effects"]] == ["cogging"]
    numbers = found["effects"][0]["parameters"]
    assert numbers["amplitude"]["value"] == pytest.approx(AMPLITUDE_NM, rel=0.05)
    assert numbers["order"]["value"] == pytest.approx(ORDER, rel=0.002)
    # the phase at zero is right, with the order beside it, where the joint was; the effect acts against what drives it
    middle = far + float(np.mean(logs[0].position))
    there = numbers["phase"]["value"] + numbers["order"]["value"] * middle
    assert np.sin(there) == pytest.approx(-np.sin(PHASE_RAD + ORDER * (middle - far)), abs=0.05)
