"""The yardstick is not the candidate's: floors never grow with the model that is judged, and an all-clear is earned."""

from __future__ import annotations

from typing import Any

import pytest

from gimbal_hil.knowledge.discrepancy import LEAST_GAP, Request, diagnose, verdict_of
from sim_backend.model import AntennaModel
from tests.discrepancy.static_rig import AXIS, Rig, log, model


def verdict_of_model(given: AntennaModel) -> dict[str, Any]:
    logs = (log(Rig(), "sweep", seed=3),), (log(Rig(), "laps", seed=4),)
    return verdict_of(diagnose(Request(given, *logs))).document


@pytest.fixture(scope="module")
def right() -> dict[str, Any]:
    return verdict_of_model(model())


@pytest.mark.parametrize("path", ["body.mass", "friction.coulomb", "friction.viscous"])
@pytest.mark.parametrize("factor", [0.5, 2.0])
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
    assert "inertia" not in {one["name"] for one in verdict["smallest_shown"] if (one["relative"] or 9.0) < 1.0}
