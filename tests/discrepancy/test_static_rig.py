"""A model without bristles on a rig with true static friction: names stand although gaps are uneven over time, and
nothing is made up.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import Request, diagnose, verdict_of
from tests.discrepancy.static_rig import AXIS, Rig, log, model


def verdict_on(rig: Rig, motion: str = "sweep", uncertainty: str = "2%") -> dict[str, Any]:
    return verdict_of(
        diagnose(Request(model(uncertainty), (log(rig, motion, seed=1),), (log(rig, "laps", seed=2),)))
    ).document


def number(verdict: dict[str, Any], effect: str, parameter: str) -> float:
    return float(next(e for e in verdict["effects"] if e["name"] == effect)["parameters"][parameter]["value"])


def test_nothing_is_named_where_the_model_is_right_or_a_few_per_cent_off() -> None:
    known = Rig()
    assert verdict_on(known)["verdict"] == "no_discrepancy"
    off = replace(known, mass=2.12, coulomb=1.12, viscous=6.4)
    assert not verdict_on(off, uncertainty="10%")["effects"]


def test_a_spring_is_named_although_it_pulls_at_the_ends_of_the_travel_only() -> None:
    verdict = verdict_on(replace(Rig(), spring=8.0))
    assert [(e["name"], e["axis"]) for e in verdict["effects"]] == [("cable_spring", AXIS)]
    assert number(verdict, "cable_spring", "stiffness") == pytest.approx(8.0, rel=0.05)


def test_an_offset_is_found_with_what_means_the_same_here() -> None:
    verdict = verdict_on(replace(Rig(), offset=0.5))
    named, others = ({e["name"] for e in verdict[which]} for which in ("effects", "alternatives"))
    assert "torque_offset" in named | others
    # friction that differs by direction is the same law on a rig that never stands; nothing else may be named
    assert len(verdict["effects"]) == 1 and named <= {"torque_offset", "coulomb_asymmetry"}


@pytest.mark.heavy
def test_a_mass_that_is_far_off_is_named_and_not_called_recalibrated() -> None:
    verdict = verdict_on(replace(Rig(), mass=2.7))
    assert [e["name"] for e in verdict["effects"]] == ["inertia"]
    assert number(verdict, "inertia", "inertia") == pytest.approx(2.7, rel=0.02)


def test_a_screws_ripple_is_found_over_many_turns() -> None:
    verdict = verdict_on(replace(Rig(), ripple=0.3), "crawl")
    assert "cogging" in {e["name"] for e in verdict["effects"]}
    # 160 turns in the travel, 2,513 rad/m
    assert number(verdict, "cogging", "order") == pytest.approx(2513.3, rel=0.002)


def test_a_screws_ripple_is_found_where_the_encoder_starts_every_log_anew() -> None:
    rig, turn_m = replace(Rig(), ripple=0.3), 2.0 * math.pi / 2513.3
    fitted, judged = log(rig, "crawl", seed=1), log(rig, "laps", seed=2)
    elsewhere = SignalsTable.of(
        (AXIS,),
        judged.time_s,
        {
            f"{AXIS}.torque": judged.torque(AXIS),
            # a third of a ripple further on
            f"{AXIS}.position": judged.position(AXIS) + turn_m / 3.0,
        },
        source="another session",
    )
    verdict = verdict_of(diagnose(Request(model("2%"), (fitted,), (elsewhere,)))).document
    assert {e["name"] for e in verdict["effects"]} == {"cogging"}
    assert number(verdict, "cogging", "order") == pytest.approx(2513.3, rel=0.002)
