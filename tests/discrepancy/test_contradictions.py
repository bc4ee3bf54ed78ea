"""Ramps that break away below what sliding needs are said to contradict the plateaus; ramps that agree with them are
not.
"""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import Request, diagnose, verdict_of
from gimbal_hil.knowledge.discrepancy.verdict.contradictions import contradictions, ramps_apart
from gimbal_hil.knowledge.identification import LugreFriction, StaticFriction
from sim_backend.model import AntennaModel, model_from_document
from tests.discrepancy.measured_rigs import ARM_FITTED, ARM_JUDGED, arm_logs, arm_model, arm_ramps
from tests.identification.one_axis_rig import (
    ENCODER_STEP,
    OUTER,
    Recorded,
    Rig,
    apply_torque,
    follow_rate,
    slow_ramp,
    there_and_back,
)

STICKIER = LugreFriction(StaticFriction(0.36, 0.34, 0.0054, 0.0609, 1.0459), 238.88, 16.02)


def model() -> AntennaModel:
    friction = {
        "breakaway": 0.3,
        "coulomb": 0.28,
        "stribeck_velocity": 0.01,
        "viscous": 0.1,
        "shape": 1.3,
        "sigma0": 240.0,
        "sigma1": 10.0,
    }
    axis = {"body": {"mass": 1.0, "inertia": {"zz": 0.5}}, "friction": friction, "encoder": {"step": ENCODER_STEP}}
    return model_from_document({"schema": 1, "name": "rig", "kind": "rotary", "axes": {"arm": axis}}, "rig")


def table(recorded: Recorded, name: str) -> SignalsTable:
    return SignalsTable.of(
        ("arm",), recorded.time_s, {"arm.torque": recorded.torque, "arm.position": recorded.position}, source=name
    )


def sliding(friction: LugreFriction) -> list[SignalsTable]:
    speeds = np.geomspace(0.001, 0.1, 10)
    recorded = follow_rate(Rig(friction), there_and_back(speeds), 7)
    columns = {"arm.torque": recorded.torque, "arm.position": recorded.position, "arm.rate_ref": recorded.rate_ref}
    return [SignalsTable.of(("arm",), recorded.time_s, columns, source="plateaus")]


def ramps() -> list[SignalsTable]:
    peak = 1.3 * OUTER.static.breakaway
    return [
        table(apply_torque(Rig(), sign * slow_ramp(peak, 20.0, (0.0, 1.0))), f"ramp {sign:+g}") for sign in (1.0, -1.0)
    ]


def test_ramps_of_one_rig_and_plateaus_of_a_stickier_one_contradict_each_other() -> None:
    found = contradictions(model(), [*sliding(STICKIER), *ramps()])
    assert [(one["rule"], one["axis"]) for one in found] == [("break_away_below_coulomb", "arm")] * 2
    assert [one["text"].split()[0] for one in found] == ["positive", "negative"]


def test_ramps_and_plateaus_of_one_rig_agree() -> None:
    assert contradictions(model(), [*sliding(OUTER), *ramps()]) == []


def test_nothing_is_said_without_ramps_or_where_what_the_model_adds_by_position_may_be_why() -> None:
    assert contradictions(model(), sliding(STICKIER)) == []
    weakly, strongly = (
        model().with_effect("cogging", "arm", {"amplitude": a, "order": 3.0, "phase": 0.0}) for a in (0.01, 0.1)
    )
    assert len(contradictions(weakly, [*sliding(STICKIER), *ramps()])) == 2
    assert contradictions(strongly, [*sliding(STICKIER), *ramps()]) == []


def test_ramps_are_kept_from_the_search_for_a_model_without_bristles_alone() -> None:
    logs = (*sliding(OUTER), *ramps())
    assert ramps_apart(model(), logs) == (logs, (), [])
    rest, apart, notes = ramps_apart(model().with_number("arm", "friction.sigma0", 0.0, "none"), logs)
    assert [table.source for table in rest] == ["plateaus"] and len(apart) == len(notes) == 2


def test_a_log_that_moves_from_the_start_is_no_ramp() -> None:
    """An open-loop swing, and one that gets going within a third of a second: both belong to the search."""
    time_s = np.arange(8000) * 1e-3
    without = model().with_number("arm", "friction.sigma0", 0.0, "none")
    swing, start = 0.9 * np.sin(np.pi * time_s), 0.9 * np.minimum(time_s / 0.3, 1.0)
    logs = tuple(table(apply_torque(Rig(), torque), f"log {i}") for i, torque in enumerate((swing, start)))
    assert ramps_apart(without, (*logs, *sliding(OUTER)))[1] == ()


@pytest.mark.heavy
def test_the_measured_arm_breaks_away_below_its_coulomb_torque() -> None:
    judged = arm_logs(ARM_JUDGED)
    fitted, apart, _ = ramps_apart(arm_model(), (*arm_logs(ARM_FITTED), *arm_ramps()))
    verdict = verdict_of(diagnose(Request(arm_model(), fitted, judged)), (*fitted, *judged, *apart)).document
    print(verdict["text"], *(one["text"] for one in verdict["contradictions"]), sep="\n")
    # what else it is told has no name (docs/measurements/measured-rigs.md)
    assert not [one for one in verdict["effects"] if one["status"] == "named"]
    assert "contradict themselves on shoulder" in verdict["text"]
    # beside the weight that the verdict moved within its uncertainty, and beside the one that is stated
    assert verdict["contradictions"][0]["text"].startswith("positive direction: 4 ramps break away at ")
    told = contradictions(arm_model(), [*fitted, *judged, *apart])[0]["text"]
    assert float(told.split(" at ")[1].split()[0]) == pytest.approx(9.5, abs=0.1)
