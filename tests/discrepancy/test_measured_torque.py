"""Commanded torque alone cannot tell a motor's back-EMF from drag in the joint; torque measured at the actuator can."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import Policy, Request, diagnose, verdict_of
from gimbal_hil.knowledge.discrepancy.judgement import measured_torque
from gimbal_hil.knowledge.discrepancy.judgement.deciding import Decision, Kind, Status, Told
from gimbal_hil.knowledge.discrepancy.judgement.exhaustion import Predictable
from gimbal_hil.knowledge.discrepancy.judgement.judging import Standing
from gimbal_hil.knowledge.discrepancy.judgement.rivals import Rival
from gimbal_hil.knowledge.estimation import Paired
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions
from gimbal_hil.knowledge.experiments.sequences.survey import survey_motion
from gimbal_hil.knowledge.improvement.rehearsal import rehearse
from gimbal_hil.loop.settings import shipped_settings
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


@pytest.mark.parametrize("clearly", [True, False])
def test_what_the_measured_torque_rules_out_gives_its_place_to_the_alternative_and_its_bounds(
    clearly: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    mine, other = (
        SimpleNamespace(hypothesis=SimpleNamespace(labels=((name, "inner"),))) for name in ("backlash", "viscous")
    )
    nothing = Predictable(0.0, 0.0)
    standing = Standing(
        (0,), ("backlash", "inner"), Paired(90.0, 0.9, 0.1, 40), 12.0, 0.95, 0.0, (), nothing, ("gap",), False, 0, 90.0,
        np.array([90.0]), True, False, 0.0, 0.02, 1.0,
    )  # fmt: skip
    rival = Rival(other, (("viscous", "inner"),), 0.0, 0.0, same=True)  # type: ignore[arg-type]
    told = Told(standing, Status.AMBIGUOUS, (rival,), 0.32, 0.96, shown=False)
    left = {id(mine): 9.0 if clearly else 1.0, id(other): 1.0}
    blocks = 1.0 + 0.01 * np.arange(20.0)
    monkeypatch.setattr(measured_torque, "torque_is_measured", lambda *_: True)
    monkeypatch.setattr(measured_torque, "_squares", lambda inquiry, state, tables: left[id(state)] * blocks)
    inquiry: Any = SimpleNamespace(logs=(), twin=SimpleNamespace(model=SimpleNamespace(axes=())), policy=Policy())
    state: Any = mine
    found = measured_torque.with_measured_torque(inquiry, Decision(Kind.AMBIGUOUS, state, (told,), ()))
    (one,) = found.told
    if clearly:
        assert found.state is other and one.standing.label == ("viscous", "inner")
        assert one.standing.at_bound == () and one.close == () and one.status is Status.AMBIGUOUS
        assert (one.of_class, one.of_names, one.probability) == (0.96, 0.96, 0.96)
    else:
        assert found.state is mine and one.standing.at_bound == ("gap",) and one.close == (rival,)
