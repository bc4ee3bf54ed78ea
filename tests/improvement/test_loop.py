"""The closed loop on virtual antennas whose effects it is not told."""

from __future__ import annotations

from pathlib import Path

import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.discrepancy import LEAST_GAP
from gimbal_hil.knowledge.improvement import Ending, Measured, read_journal
from sim_backend.model import AntennaModel, shipped_model
from tests.improvement.antennas import judged, with_a_bump
from tests.improvement.sessions import improved, task_of, virtual

COGGING = {"amplitude": 0.03, "order": 12.0, "phase": 0.7}


@pytest.mark.heavy
def test_an_antenna_without_hidden_effects_ends_at_the_floor_after_two_surveys_with_the_model_unchanged(
    tmp_path: Path,
) -> None:
    site = virtual(shipped_model())
    done = improved(task_of(tmp_path), site)
    assert done.ending is Ending.AT_THE_FLOOR
    assert done.model.document == shipped_model().document
    assert site.runs == ["survey", "survey_holdout"]


@pytest.mark.heavy
def test_a_stopped_improvement_goes_on_without_making_finished_runs_again(tmp_path: Path) -> None:
    antenna = shipped_model()
    site = virtual(antenna)
    site.interrupted_before = 2
    with pytest.raises(KeyboardInterrupt):
        improved(task_of(tmp_path), site)
    assert site.runs == ["survey"]
    again = virtual(antenna)
    done = improved(task_of(tmp_path), again, resume=True)
    assert again.runs == ["survey_holdout"]
    assert done.ending is Ending.AT_THE_FLOOR
    entries = [entry for entry in read_journal(tmp_path / "journal.jsonl") if isinstance(entry, Measured)]
    assert [entry.sequence for entry in entries] == ["survey", "survey_holdout"]
    assert done.antenna_s == entries[-1].antenna_s
    # once more: everything is there, and nothing moves
    third = virtual(antenna)
    assert improved(task_of(tmp_path), third, resume=True).ending is Ending.AT_THE_FLOOR
    assert third.runs == []


@pytest.mark.parametrize(
    "budget",
    [
        {"antenna_s": 1.0},
        {"torque": {"outer": 0.5}},
        {"travel": {"inner": (-0.2, 0.2)}},
    ],
    ids=["time", "torque", "travel"],
)
def test_a_survey_that_would_exceed_a_budget_is_refused_before_anything_moves(
    tmp_path: Path, budget: dict[str, object]
) -> None:
    site = virtual(shipped_model())
    with pytest.raises(BadInputError, match="the first survey"):
        improved(task_of(tmp_path, **budget), site)  # type: ignore[arg-type]
    assert site.runs == []


def test_time_for_one_survey_alone_ends_with_the_time_used_up(tmp_path: Path) -> None:
    site = virtual(shipped_model())
    done = improved(task_of(tmp_path, antenna_s=50.0), site)
    assert done.ending is Ending.TIME_USED_UP
    assert site.runs == ["survey"]


def limited(limit: float) -> AntennaModel:
    """The first survey asks for 2.6 N m on the inner axis, the second one for 2.0."""
    return shipped_model().with_number("inner", "actuator.limit", limit, "hidden")


def roles(folder: Path) -> list[str]:
    return [entry.role for entry in read_journal(folder / "journal.jsonl") if isinstance(entry, Measured)]


@pytest.mark.heavy
def test_a_cause_that_the_judging_motion_does_not_show_gets_a_hold_out_that_does(tmp_path: Path) -> None:
    site = virtual(limited(2.2))
    site.interrupted_before = 4
    with pytest.raises(KeyboardInterrupt):
        improved(task_of(tmp_path), site)
    assert roles(tmp_path) == ["search", "judge", "shown"]
    # a stopped improvement knows what was shown already, and judges on a motion that no model has seen
    site = virtual(limited(2.2))
    done = improved(task_of(tmp_path), site, resume=True)
    assert done.ending is Ending.AT_THE_FLOOR
    assert done.model.number("inner", "actuator.limit") == pytest.approx(2.2, rel=0.02)
    assert roles(tmp_path) == ["search", "judge", "shown", "judge"]
    verdicts = [one.verdict for one in done.diagnoses]
    # what was taken over may be looked at once more on what was measured already, before a new motion judges it
    assert verdicts[:2] == ["ambiguous", "named"]
    assert set(verdicts[2:]) == {"no_discrepancy"} and len(verdicts) <= 4


@pytest.mark.heavy
def test_a_cause_that_no_run_within_the_budgets_shows_again_stays_suspected(tmp_path: Path) -> None:
    # time for the two surveys and for nothing else
    done = improved(task_of(tmp_path, antenna_s=75.0), virtual(limited(2.2)))
    assert done.ending is Ending.SUSPECTED
    assert "Saturation on inner is suspected, not shown" in done.text
    assert "s of antenna time" in done.text
    assert roles(tmp_path) == ["search", "judge"]


HIDDEN = (
    (("cogging", "outer", COGGING), ("coulomb_asymmetry", "inner", {"asymmetry": 0.15})),
    (("cogging", "outer", COGGING), ("cable_spring", "inner", {"stiffness": 0.4, "rest_position": 0.0})),
)


@pytest.mark.heavy
@pytest.mark.parametrize("hidden", HIDDEN)
def test_two_hidden_effects_are_added_until_the_model_is_at_the_floor(
    tmp_path: Path, hidden: tuple[tuple[str, str, dict[str, float]], ...]
) -> None:
    antenna = shipped_model()
    for name, axis, parameters in hidden:
        antenna = antenna.with_effect(name, axis, parameters)
    done = improved(task_of(tmp_path), virtual(antenna))
    assert done.ending is Ending.AT_THE_FLOOR
    named = {(effect["name"], effect["axis"]) for one in done.diagnoses for effect in one.effects}
    assert named == {(name, axis) for name, axis, _ in hidden}


@pytest.mark.heavy
def test_a_cause_outside_the_catalogue_ends_unexplained_with_the_model_unchanged(tmp_path: Path) -> None:
    done = improved(task_of(tmp_path), virtual(with_a_bump()))
    assert done.ending is Ending.UNEXPLAINED
    assert done.model.document == shipped_model().document
    assert "inner" in done.text


def with_moments(share: float) -> AntennaModel:
    """The shipped antenna with every moment and product of inertia off by a share."""
    antenna = shipped_model()
    for axis in antenna.axes:
        tensor = [f"body.inertia.{one}" for one in ("xx", "yy", "zz", "xy", "xz", "yz")]
        numbers = {path: (1.0 + share) * antenna.number(axis, path) for path in tensor}
        antenna = antenna.with_numbers(axis, numbers, "hidden")
    return antenna


TURNED = tuple(
    (axis, f"body.inertia.{one}") for axis, one in (("inner", "yy"), ("outer", "zz"), ("inner", "zz"), ("inner", "xx"))
)


@pytest.mark.heavy
def test_every_tensor_a_fifth_larger_than_the_model_says_is_found_to_the_floor(tmp_path: Path) -> None:
    antenna = with_moments(0.2)
    done = improved(task_of(tmp_path), virtual(antenna))
    assert done.ending is Ending.AT_THE_FLOOR
    assert judged(antenna, done.model) < LEAST_GAP
    assert len(done.diagnoses) <= 4
    found, true = ([m.number(*place) for place in TURNED] for m in (done.model, antenna))
    assert found[0] == pytest.approx(true[0], rel=0.005)
    # a level antenna tells only what the outer joint carries in each pose
    for i in (2, 3):
        assert found[1] + found[i] == pytest.approx(true[1] + true[i], rel=0.005)
    # moments about axes that nothing turned keep what was said of them
    unseen = done.model.numbers["outer", "body.inertia.xx"]
    assert unseen.value == shipped_model().number("outer", "body.inertia.xx")
    assert not (unseen.source or "").startswith("identified")
