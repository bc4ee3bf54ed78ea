"""The yardstick is not the candidate's: floors never grow with the model that is judged, and an all-clear is earned."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy import (
    LEAST_GAP,
    Request,
    Result,
    attributed,
    diagnose,
    recalibrated_model,
    verdict_of,
)
from gimbal_hil.knowledge.discrepancy.hypotheses import command_residual
from gimbal_hil.knowledge.discrepancy.inquiry import Noise
from gimbal_hil.knowledge.discrepancy.judgement.smallest import without_own
from gimbal_hil.knowledge.discrepancy.noise import Floor, WideTwin
from gimbal_hil.pages.report import quantity
from sim_backend.model import AntennaModel
from tests.discrepancy.static_rig import AXIS, Rig, log, model
from tests.parts import heavy_but


def diagnosed(given: AntennaModel) -> Result:
    return diagnose(Request(given, (log(Rig(), "sweep", seed=3),), (log(Rig(), "laps", seed=4),)))


def verdict_of_model(given: AntennaModel) -> dict[str, Any]:
    return verdict_of(diagnosed(given)).document


@pytest.fixture(scope="module")
def result() -> Result:
    return diagnosed(model())


@pytest.fixture(scope="module")
def right(result: Result) -> dict[str, Any]:
    return verdict_of(result).document


@pytest.mark.parametrize("path", ["body.mass", "friction.coulomb", "friction.viscous"])
@pytest.mark.parametrize("factor", heavy_but((0.5,), (0.5, 2.0)))
def test_a_planted_error_raises_no_floor_and_gets_no_all_clear(right: dict[str, Any], path: str, factor: float) -> None:
    given = model()
    values = {path: factor * given.number(AXIS, path)}
    if path == "friction.coulomb":
        values["friction.breakaway"] = factor * given.number(AXIS, "friction.breakaway")
    verdict = verdict_of_model(given.with_numbers(AXIS, values))
    # less than what counts as a gap: the error cannot hide in it
    assert verdict["gap"]["noise_floor"] < LEAST_GAP * right["gap"]["noise_floor"]
    assert verdict["verdict"] not in ("no_discrepancy", "cannot_judge"), verdict["text"]


def test_an_all_clear_says_from_which_size_on_errors_would_have_shown(right: dict[str, Any]) -> None:
    assert right["verdict"] == "no_discrepancy"
    sizes = {one["name"]: one["relative"] for one in right["smallest_shown"]}
    assert sizes["inertia"] < 0.1 and sizes["coulomb"] < 0.1
    assert "Smallest errors that would have shown" in right["text"] and "inertia" in right["text"]
    assert right["would_not_show"] == []


def test_an_error_that_the_hold_out_would_not_repeat_has_to_be_larger_to_show(right: dict[str, Any]) -> None:
    crawling = Request(model(), (log(Rig(), "sweep", seed=3),), (log(Rig(), "crawl", seed=4),))
    sizes = [
        next(one["relative"] for one in said["smallest_shown"] if one["name"] == "inertia")
        for said in (right, verdict_of(diagnose(crawling)).document)
    ]
    # two floors of the fitted log alone, in place of one and a half of both
    assert 1.1 * sizes[0] < sizes[1] < 2.0 * sizes[0]


def test_a_number_that_moved_stands_where_the_model_has_it_before_its_errors_are_sized(result: Result) -> None:
    inquiry = result.inquiry
    family = next(family for family in inquiry.families if family.effect == "coulomb")
    bare, own = without_own(inquiry, result.null, family)
    assert {"friction.coulomb"} <= {known.path for known in own}
    assert np.allclose(bare.residual, command_residual(inquiry.twin, bare.hypothesis, inquiry.floor))
    assert not np.allclose(bare.residual, result.null.fitted)


@pytest.mark.heavy
def test_an_error_of_the_size_that_would_have_shown_does_show(right: dict[str, Any]) -> None:
    size = next(one["relative"] for one in right["smallest_shown"] if one["name"] == "inertia")
    given = model()
    mass = given.number(AXIS, "body.mass")
    twice = verdict_of_model(given.with_number(AXIS, "body.mass", mass * (1.0 + 2.0 * size)))
    assert twice["verdict"] != "no_discrepancy", twice["text"]


def test_a_log_that_hardly_accelerates_cannot_judge_an_inertia() -> None:
    slow = tuple(log(Rig(), "crawl", seed=seed) for seed in (5, 6))
    verdict = verdict_of(diagnose(Request(model("80%"), slow[:1], slow[1:]))).document
    assert verdict["verdict"] == "cannot_judge", verdict["text"]
    assert "inertia" in verdict["next_experiment"]["separates"]
    assert {"name": "inertia", "axis": AXIS} in verdict["would_not_show"]
    assert "These logs would not have shown half or twice the right" in verdict["text"]
    limit = quantity(LEAST_GAP * verdict["gap"]["noise_floor"], "N")
    assert f"do not show: {limit} in the torque of {AXIS}" in verdict["text"]


def test_what_the_model_itself_allows_to_be_twice_as_large_is_not_judged() -> None:
    # 80 % as a factor is 2.2, up and down
    verdict = verdict_of_model(model("80%"))
    assert verdict["verdict"] == "cannot_judge", verdict["text"]
    assert {"inertia", "coulomb"} <= {one["name"] for one in verdict["would_not_show"]}


def test_numbers_that_moved_are_told_and_written_as_well_as_the_logs_know_them() -> None:
    given, path = model("50%"), "body.mass"
    wrong = given.with_number(AXIS, path, 1.4 * given.number(AXIS, path))
    result = diagnosed(wrong)
    verdict = verdict_of(result)
    assert f"where known numbers move within their stated uncertainty: {AXIS} {path}" in verdict.text
    said = attributed(wrong, recalibrated_model(result), verdict)
    assert abs(said.number(AXIS, path) / given.number(AXIS, path) - 1.0) < 0.05
    assert said.uncertainty(AXIS, path) < 0.1 * said.number(AXIS, path)


def test_a_floor_is_none_where_an_explanation_leaves_less() -> None:
    floors, nothing = (Floor(1.0, None, 1.0), Floor(2.0, None, 2.0)), np.zeros(2)
    lower = Noise(floors, nothing, wide=cast(WideTwin, None), from_encoder=nothing).at_most(np.array([0.5, 3.0]))
    assert [floor.rms for floor in lower.floors] == [0.5, 2.0]
