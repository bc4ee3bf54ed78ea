"""The bench itself: draws are reproducible, the truth stays apart, and the scorer says of a verdict what it was
worth.
"""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.discrepancy import Policy
from gimbal_hil.proof.bench import BlindChoice
from sim_backend.model import model_from_document
from tests.blind import magnitude
from tests.blind.causes import BODY as THESIS_BODY
from tests.blind.causes import LEAST
from tests.blind.compare import comparison
from tests.blind.draw import Unstable, Wrong, draw
from tests.blind.figures import CaseResult, case_result, reliability
from tests.blind.files import model_document, write_case
from tests.blind.guests import ROWS, SOURCES, install
from tests.blind.kinds import KINDS, Job, Part, Stated, all_jobs, jobs, sealed_seed
from tests.blind.page import write_page
from tests.blind.policy import changed, rows
from tests.blind.rig import STRANGERS, rig_named
from tests.blind.run import _judge
from tests.blind.scene import Scene, is_body
from tests.blind.score import Outcome, numbers_found, outcome, told_class
from tests.blind.tally import tables, targets

SHORT = {"duration_s": 6.0}


def cause(name: str, axis: str = "outer", floors: float = 10.0, **more: Any) -> dict[str, Any]:
    return {
        "name": name,
        "axis": axis,
        "inside": True,
        "number": False,
        "akin": [],
        "magnitude_floors": floors,
        "row": {},
        "body": {},
    } | more


def truth_of(*causes: dict[str, Any], off: float = 0.0, off_numbers: tuple[dict[str, Any], ...] = ()) -> dict[str, Any]:
    return {"causes": list(causes), "off": off, "off_numbers": list(off_numbers), "stated": "SHIPPED"}


def effect(name: str, axis: str = "outer", status: str = "named", **more: Any) -> dict[str, Any]:
    return {"name": name, "axis": axis, "status": status, "parameters": {}, "confidence": 0.9} | more


def verdict_of(
    *effects: dict[str, Any], alternatives: tuple[dict[str, Any], ...] = (), run: bool = False, **more: Any
) -> dict[str, Any]:
    said = "no_discrepancy" if not effects else "named" if all(e["status"] == "named" for e in effects) else "ambiguous"
    plan = {"plan": "turn", "separates": []} if run else None
    return {
        "verdict": said,
        "effects": list(effects),
        "alternatives": list(alternatives),
        "next_experiment": plan,
        "gap": None,
    } | more


@pytest.mark.heavy
def test_the_same_seed_and_name_draw_the_same_case_and_another_seed_another() -> None:
    job = next(job for job in all_jobs() if job.kind == "pair")
    first, again = (draw(job.seed(4), **job.arguments, **SHORT) for _ in range(2))
    assert first.truth == again.truth
    assert all(np.array_equal(first.measured[0][name], again.measured[0][name]) for name in first.measured[0])
    assert job.seed(4) != job.seed(5)


def test_every_case_has_its_own_name_and_the_kinds_come_mixed() -> None:
    listed = jobs(3)
    assert len({job.name for job in listed}) == len(listed)
    assert {job.kind for job in listed[:100]} >= set(KINDS) - {"rotary", "linear", "floating", "floating_null"}
    assert [job.name for job in listed] != [job.name for job in jobs(4)]
    assert sum(job.kind in ("null", "wander") for job in listed) == 200


def test_so_many_of_a_kind_are_the_same_ones_whichever_kinds_are_asked_for() -> None:
    alone = [job.name for job in jobs(3, Part(("null",), most=5))]
    assert alone == [job.name for job in jobs(3, Part(most=5)) if job.kind == "null"] and len(alone) == 5
    assert jobs(3, Part(most=5))[:7] == jobs(3, Part(most=5, first=7))
    assert {job.name for job in jobs(3, Part(like="single.cogging.inner.*"))} == {
        f"single.cogging.inner.{k}" for k in range(3)
    }
    with pytest.raises(BadInputError, match="no kind 'nulls'"):
        jobs(3, Part(("nulls",)))
    with pytest.raises(BadInputError, match="no case is like"):
        jobs(3, Part(like="coggin"))


def test_a_sealed_seed_is_that_of_the_release_s_commit(tmp_path: Path) -> None:
    checkout = Path(__file__).resolve().parents[2]
    if not (checkout / ".git").exists():
        pytest.skip("needs the history")
    assert sealed_seed("HEAD", checkout) == sealed_seed("HEAD", checkout)
    with pytest.raises(BadInputError, match="no release"):
        sealed_seed("v99.99.99", checkout)


@pytest.mark.heavy
def test_the_data_folder_holds_logs_and_model_and_nothing_of_the_truth(tmp_path: Path) -> None:
    job = Job("known.0", {"rig": "plain", "off": 0.10, "wrong": Wrong(2, 0.25, 0.25)} | SHORT, Stated.MEASURED)
    write_case(job, 1, tmp_path)
    assert sorted(path.name for path in (tmp_path / "data").iterdir()) == [
        "holdout_0.parquet",
        "measured_0.parquet",
        "measured_1.parquet",
        "model.yaml",
    ]
    truth = json.loads((tmp_path / "truth.json").read_text())
    assert sum(c["number"] for c in truth["causes"]) == 2
    stated = (tmp_path / "data" / "model.yaml").read_text()
    assert "measured" in stated and not any(str(n["true"]) in stated for n in truth["off_numbers"])


@pytest.mark.parametrize("rig", STRANGERS)
def test_a_stranger_s_model_is_one_that_the_product_takes(rig: str) -> None:
    drawn = rig_named(rig, np.random.default_rng(1))
    model = model_from_document(model_document(drawn, Stated.EXACT), rig)
    assert model.axes == drawn.names


@pytest.mark.heavy
def test_five_wrong_numbers_are_20_to_33_percent_off_in_the_antenna_not_in_the_model() -> None:
    case = draw(11, [], rig="plain", wrong=Wrong(5, 0.20, 0.33), **SHORT)
    causes = case.truth["causes"]
    assert isinstance(causes, list) and len(causes) == 5 and all(c["number"] for c in causes)
    off = {(n["axis"], n["path"]): n["true"] / n["model"] - 1.0 for n in case.truth["off_numbers"]}  # type: ignore[attr-defined]
    plain = {key: change for key, change in off.items() if not key[1].endswith(("breakaway", "sigma1"))}
    assert len(plain) >= 5 and all(0.199 <= abs(change) <= 0.331 for change in plain.values())


@pytest.mark.heavy
@pytest.mark.parametrize(("name", "axis"), [("inertia", "inner"), ("dynamic_unbalance", "inner")])
def test_what_is_hidden_in_a_body_leaves_it_a_body(name: str, axis: str) -> None:
    drawn = 0
    for seed in range(40, 52):
        with contextlib.suppress(Unstable):
            case = draw(seed, [name], axis=axis, magnitude=30.0, **SHORT)
            drawn += 1
            row = THESIS_BODY[axis].copy()
            for key, value in case.truth["causes"][0]["body"].items():  # type: ignore[index]
                row[int(key)] = value
            assert is_body(row)
    assert drawn >= 3


def test_a_magnitude_is_that_of_the_size_that_is_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    # a trace that grows with the square root of the size, beside noise of three floors
    monkeypatch.setattr(magnitude, "_alone", lambda scene, k, scale, floors: np.hypot(3.0, 50.0 * np.sqrt(scale)))
    scene = cast(Scene, SimpleNamespace(causes=[SimpleNamespace(name="viscous", number=False)]))
    ((scale, reached),) = magnitude.scaled_to(scene, [0.8], np.ones(3))
    assert reached == pytest.approx(50.0 * np.sqrt(scale)) and scale < 0.01
    lag = cast(Scene, SimpleNamespace(causes=[SimpleNamespace(name="actuator_lag", number=False)]))
    ((scale, reached),) = magnitude.scaled_to(lag, [0.8], np.ones(3))
    assert scale == LEAST["actuator_lag"] and reached == pytest.approx(50.0 * np.sqrt(scale))


def test_a_level_that_wanders_changes_the_torque_and_is_no_cause() -> None:
    still, moved = (draw(12, [], wander=wander, **SHORT) for wander in (False, True))
    assert not moved.truth["causes"]
    assert np.array_equal(still.measured[0]["outer.torque"][:1], moved.measured[0]["outer.torque"][:1])
    assert 1e-5 < np.std(still.measured[0]["outer.torque"] - moved.measured[0]["outer.torque"]) < 0.1


def test_a_guest_is_installed_as_a_package_that_the_catalogue_takes(tmp_path: Path) -> None:
    import importlib.metadata

    for name in SOURCES:
        install(name, tmp_path)
    found = {e.name: e.value for d in importlib.metadata.distributions(path=[str(tmp_path)]) for e in d.entry_points}
    assert found == {f"guest_{name}": f"guest_{name}:EFFECT" for name in SOURCES}
    case = draw(3, ["hardening_stop"], axis="outer", outside_cause=True, plugged_in=True, **SHORT)
    row = case.truth["causes"][0]["row"]  # type: ignore[index]
    assert set(ROWS["hardening_stop"].values()) <= set(row) and case.truth["causes"][0]["inside"]  # type: ignore[index]


COGGING, SPRING = cause("cogging"), cause("cable_spring")
STRANGE = cause("slosh", inside=False, akin=["structural_resonance"])
SMALL, LARGE = cause("viscous", floors=1.0, number=True), cause("inertia", floors=50.0, number=True)
INSTEAD = ({"name": "cogging", "axis": "outer", "instead_of": "encoder_eccentricity"},)
NEAR = ({"axis": "outer", "path": "friction.viscous", "model": 1.0, "true": 1.08},)
LACKING = {"lacking": [["presliding", "outer"]]}
WORTH: dict[str, tuple[dict[str, Any], dict[str, Any], Outcome]] = {
    "named": (truth_of(COGGING), verdict_of(effect("cogging")), Outcome.EXACT),
    "named with two orders": (truth_of(COGGING), verdict_of(effect("cogging"), effect("cogging")), Outcome.EXACT),
    "on the wrong axis": (truth_of(COGGING), verdict_of(effect("cogging", "inner")), Outcome.FALSE),
    "with a phantom": (truth_of(COGGING), verdict_of(effect("cogging"), effect("viscous")), Outcome.FALSE),
    "with a phantom and a run": (
        truth_of(COGGING),
        verdict_of(effect("cogging"), effect("viscous"), run=True),
        Outcome.FALSE,
    ),
    "half": (truth_of(COGGING, SPRING), verdict_of(effect("cogging")), Outcome.PARTLY),
    "nothing said": (truth_of(COGGING), verdict_of(), Outcome.MISSED),
    "a guess that is right": (
        truth_of(COGGING),
        verdict_of(effect("cogging", status="ambiguous"), run=True),
        Outcome.CLASS,
    ),
    "a class": (
        truth_of(COGGING),
        verdict_of(effect("encoder_eccentricity", status="ambiguous"), alternatives=INSTEAD, run=True),
        Outcome.CLASS,
    ),
    "a class without a run": (
        truth_of(COGGING),
        verdict_of(effect("encoder_eccentricity", status="ambiguous"), alternatives=INSTEAD),
        Outcome.FALSE,
    ),
    "a class that does not hold it": (
        truth_of(SPRING),
        verdict_of(effect("encoder_eccentricity", status="ambiguous"), alternatives=INSTEAD, run=True),
        Outcome.FALSE,
    ),
    "back-EMF for viscous": (truth_of(cause("viscous")), verdict_of(effect("back_emf")), Outcome.EXACT),
    "nothing is nothing": (truth_of(), verdict_of(), Outcome.ABSTAINED),
    "a name for nothing": (truth_of(), verdict_of(effect("cogging")), Outcome.FALSE),
    "a guess for nothing": (truth_of(), verdict_of(effect("cogging", status="ambiguous")), Outcome.GUESSED),
    "a stranger unnamed": (truth_of(STRANGE), verdict_of(), Outcome.ABSTAINED),
    "a stranger's nearest": (truth_of(STRANGE), verdict_of(effect("structural_resonance")), Outcome.AKIN),
    "a stranger's false name": (truth_of(STRANGE), verdict_of(effect("cogging")), Outcome.FALSE),
    "a number that shows": (truth_of(SMALL, LARGE), verdict_of(effect("inertia")), Outcome.EXACT),
    "and one that does not": (truth_of(SMALL, LARGE), verdict_of(effect("inertia"), effect("viscous")), Outcome.EXACT),
    "only one that does not": (truth_of(SMALL, LARGE), verdict_of(effect("viscous")), Outcome.PARTLY),
    "a number within its uncertainty": (
        truth_of(off=0.08, off_numbers=NEAR),
        verdict_of(effect("viscous")),
        Outcome.NEAR,
    ),
    "beside an effect": (
        truth_of(COGGING, off=0.08, off_numbers=NEAR),
        verdict_of(effect("cogging"), effect("viscous")),
        Outcome.EXACT,
    ),
    "what the model lacks anyway": (
        truth_of(COGGING) | LACKING,
        verdict_of(effect("cogging"), effect("presliding")),
        Outcome.EXACT,
    ),
    "that alone": (truth_of() | LACKING, verdict_of(effect("presliding")), Outcome.AKIN),
    "refused": (truth_of(), verdict_of(verdict="unusable_data"), Outcome.NO_ANSWER),
}


@pytest.mark.parametrize("what", WORTH)
def test_the_scorer_says_what_a_verdict_was_worth(what: str) -> None:
    truth, verdict, expected = WORTH[what]
    assert outcome(truth, verdict) is expected


def test_a_wrong_number_counts_as_found_when_it_was_recalibrated_to_the_truth() -> None:
    number = cause("viscous", floors=50.0, number=True, row={"s2": 1.3})
    truth = truth_of(number, off_numbers=({"axis": "outer", "path": "friction.viscous", "model": 1.0, "true": 1.3},))
    moved = [{"axis": "outer", "path": "friction.viscous", "from": 1.0, "to": 1.25}]
    assert numbers_found(truth, verdict_of(effect("viscous"))) == [("viscous@outer", True, True)]
    assert numbers_found(truth, verdict_of(recalibrated=moved)) == [("viscous@outer", False, True)]
    assert numbers_found(truth, verdict_of()) == [("viscous@outer", False, False)]


def judged(name: str, truth: dict[str, Any], verdict: dict[str, Any]) -> CaseResult:
    return case_result(name, truth, verdict, {"wall": 10.0, "cpu": 9.0})


def test_reliability_sets_the_told_probability_beside_the_share_that_is_right() -> None:
    right, wrong = verdict_of(effect("cogging", probability=0.9)), verdict_of(effect("viscous", probability=0.88))
    cases = [judged(f"single.cogging.outer.{i}", truth_of(COGGING), right if i < 9 else wrong) for i in range(10)]
    (found,) = reliability(cases)
    assert (found.low, found.high, found.right.part, found.right.whole) == (0.85, 0.95, 9, 10)
    assert found.told == pytest.approx(0.898)
    assert found.right.interval == pytest.approx((0.596, 0.982), abs=0.002)
    assert judged("single.a.outer.0", truth_of(COGGING), verdict_of(effect("cogging"))).told[0][2] == 0.9


def test_a_class_is_right_when_a_told_name_or_an_alternative_is() -> None:
    guess = effect("encoder_eccentricity", status="ambiguous")
    assert told_class(truth_of(COGGING), verdict_of(guess, alternatives=INSTEAD, something_else=0.1)) == (0.9, True)
    assert told_class(truth_of(SPRING), verdict_of(guess, alternatives=INSTEAD, something_else=0.1)) == (0.9, False)
    assert told_class(truth_of(SPRING), verdict_of(something_else=0.6)) is None


def test_the_tables_count_what_was_judged() -> None:
    cases = [
        judged("single.cogging.outer.0", truth_of(COGGING), verdict_of(effect("cogging"))),
        judged("null.1", truth_of(), verdict_of()),
    ]
    reached = {figure: text for figure, _, text in targets(cases)}
    assert reached["medium and large: exact name and axis"].startswith("1/1")
    assert reached["nulls with nothing hidden: `no_discrepancy`"].startswith("1/1")
    assert reached["pairs (both at least 2 floors): both names"] == "-"
    assert "| null | 1 |" in tables(cases, 3, None)


def test_the_page_shows_figures_and_the_reliability_diagram(tmp_path: Path) -> None:
    cases = [judged("single.cogging.outer.0", truth_of(COGGING), verdict_of(effect("viscous", probability=0.7)))]
    page = write_page(cases, 3, "v1.0", tmp_path / "report.html").read_text()
    assert "sealed with v1.0" in page and "Reliability of what is told" in page and "single.cogging.outer.0" in page


def test_two_folders_of_one_seed_are_compared_case_by_case(tmp_path: Path) -> None:
    said = {"old": verdict_of(), "new": verdict_of(effect("cogging"))}
    for folder, verdict in said.items():
        case = tmp_path / folder / "single.cogging.outer.0"
        case.mkdir(parents=True)
        for name, content in (
            ("truth", truth_of(COGGING)),
            ("verdict", verdict),
            ("seconds", {"wall": 3.0, "cpu": 2.0}),
        ):
            (case / f"{name}.json").write_text(json.dumps(content))
        (tmp_path / folder / "bench.json").write_text(json.dumps({"seed": 1, "sealed": None, "code": "x"}))
    text = comparison(tmp_path / "old", tmp_path / "new")
    assert "became right: 1" in text and "MISSED (no_discrepancy) -> EXACT (cogging@outer)" in text
    assert "became wrong: 1" in comparison(tmp_path / "new", tmp_path / "old")
    with pytest.raises(BadInputError, match="holds no results"):
        comparison(tmp_path / "old", tmp_path)


def test_the_command_passes_the_choice_on_and_leaves_out_what_was_not_chosen(tmp_path: Path) -> None:
    words = BlindChoice(tmp_path, seed=7, kinds=("null", "pair"), most=3, table=True).words()
    assert words == [
        str(tmp_path),
        "--seed",
        "7",
        "--kinds",
        "null,pair",
        "--most",
        "3",
        "--workers",
        "2",
        "--keep",
        "wrong",
        "--table",
    ]


def test_a_policy_with_one_number_changed_is_the_policy_otherwise() -> None:
    for field in fields(Policy):
        moved = changed((field.name, 2.0))
        assert getattr(moved, field.name) != getattr(Policy(), field.name)
        assert replace(moved, **{field.name: getattr(Policy(), field.name)}) == Policy()
    assert changed(("", 1.0)) == Policy() and changed(("named", 2.0)).named < 1.0


def test_a_policy_s_curve_counts_only_cases_that_every_change_has() -> None:
    ended = {
        "a": {"*1": "EXACT", "sure*2": "MISSED"},
        "b": {"*1": "FALSE", "sure*2": "ABSTAINED"},
        "c": {"*1": "FALSE"},
    }
    assert rows(ended, [("", 1.0), ("sure", 2.0)]) == [
        ("as it is", "-", "2", "1", "1", "0", "0"),
        ("sure", "4", "2", "1", "0", "1", "0"),
    ]


@pytest.mark.parametrize("workers", [1, 2])
def test_a_bench_that_is_done_is_done(workers: int, tmp_path: Path) -> None:
    _judge(tmp_path, [], 1, workers, None, 10, "none")


COMMAND = [sys.executable, "-c", "from gimbal_hil.surface.cli import main; main()", "bench", "blind"]


@pytest.mark.heavy
def test_the_exit_code_of_the_command_is_the_benchs_and_paths_are_meant_from_where_it_was_given(
    tmp_path: Path,
) -> None:
    words = [*COMMAND, "--out", "cases", "--table"]
    said = subprocess.run(words, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert said.returncode == 2
    assert f"{tmp_path / 'cases'}: holds no results of a blind bench" in said.stderr
