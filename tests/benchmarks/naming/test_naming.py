"""The public test: whole, frozen, free of the product, and a judge that cannot be talked round."""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from tests.benchmarks.naming.cases import all_tasks, fingerprint
from tests.benchmarks.naming.folders import write_case
from tests.benchmarks.naming.pictures import drawn, reliability
from tests.benchmarks.naming.rivals.answers import write_answer
from tests.benchmarks.naming.rivals.product import said, told_by
from tests.benchmarks.naming.run import RIVALS, answered, scores_of, table
from tests.benchmarks.naming.scoring import Score, score, tally
from tests.benchmarks.naming.tables import read_csv, write_csv
from tests.blind.causes import catalogue, outside

ROOT = Path(__file__).resolve().parents[3]
PACKAGE = Path(__file__).parent
#: adapters of libraries that the tests do not have
ELSEWHERE = ("sindy", "narmax", "genetic", "operon", "mujoco_id", "structural")


def test_nothing_of_the_product_is_imported() -> None:
    modules = [
        ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for path in sorted(PACKAGE.rglob("*.py"))
        if path != Path(__file__) and path.stem not in ELSEWHERE
    ]
    program = (
        "import sys, types\n"
        "for room in ('firmware_protocol', 'sim_backend', 'gimbal_hil'): sys.modules[room] = None\n"
        # the package of all tests loads the product, for its threads' sake; this one asks nothing of it
        "package = sys.modules['tests'] = types.ModuleType('tests')\n"
        "package.__path__ = ['tests']\n" + "\n".join(f"import {name}" for name in modules)
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-1000:]


def test_adapters_of_others_ask_for_the_product_no_more_than_that() -> None:
    for path in (PACKAGE / "rivals").glob("*.py"):
        assert not [line for line in path.read_text().splitlines() if line.startswith(("from gimbal", "import gimbal"))]


def test_every_adapter_can_be_asked_by_its_name() -> None:
    adapters = {path.stem for path in (PACKAGE / "rivals").glob("*.py") if "__main__" in path.read_text()}
    assert adapters == set(RIVALS)


def test_of_a_ripple_that_was_told_only_columns_of_its_order_predict() -> None:
    told = {"effects": [{"name": "cogging", "axis": "outer", "parameters": {"order": {"value": 6.9}}}]}
    columns = [f"cogging#{order}" for order in range(1, 12)]
    assert [column for column in columns if said(column, "outer", told)] == ["cogging#6", "cogging#7"]
    assert not said("cogging#7", "inner", told) and not said("viscous", "outer", told)


def test_alternatives_of_an_ambiguous_verdict_share_what_their_class_has_beyond_it() -> None:
    effect = {"name": "actuator_lag", "axis": "outer", "probability": 0.5, "probability_of_class": 0.9}
    other = {"name": "transport_delay", "axis": "outer", "instead_of": "actuator_lag", "instead_of_axis": "outer"}
    told = told_by({"effects": [effect | {"status": "ambiguous"}], "alternatives": [other]})
    assert told == {("actuator_lag", "outer"): 0.49, ("transport_delay", "outer"): pytest.approx(0.41)}
    assert told_by({"effects": [effect | {"status": "named"}]}) == {("actuator_lag", "outer"): 0.5}


def test_that_all_names_are_wrong_is_as_likely_as_a_tool_says_or_as_independent_names_have_it(tmp_path: Path) -> None:
    told, torque = {("viscous", "outer"): 0.5, ("inertia", "inner"): 0.6}, {"outer": np.zeros(3)}
    for stated, expected in ((None, 0.2), (0.1, 0.1)):
        write_answer(tmp_path, told, torque, stated)
        answer = json.loads((tmp_path / "answer.json").read_text())
        assert answer["something_else"] == pytest.approx(expected)
    write_answer(tmp_path, {}, torque)
    assert json.loads((tmp_path / "answer.json").read_text()) == {"effects": [], "something_else": 1.0}


def test_the_list_of_cases_is_frozen() -> None:
    tasks = all_tasks()
    assert len(tasks) == len({task.name for task in tasks}) == 200
    # a change of the list makes every table of before worthless: it needs a new name, not a new figure here
    assert fingerprint() == "4c74cecad0f6817b"


def test_every_kind_of_the_generator_is_in_it() -> None:
    dice = np.random.default_rng(0)
    hidden = {name for task in all_tasks() for name in task.arguments.get("names", ())}
    assert {cause.name for cause in (*catalogue(dice, "outer", 0), *outside(dice, "outer"))} <= hidden
    assert min(Counter(task.kind for task in all_tasks()).values()) >= 8


TRUTH = {
    "task": "single.cogging.outer.0",
    "causes": [
        {"name": "cogging", "axis": "outer", "inside": True, "number": False, "magnitude_floors": 9.0, "akin": []}
    ],
}
NOTHING = {"task": "null.0", "causes": []}


@pytest.fixture
def judged(tmp_path: Path):  # type: ignore[no-untyped-def]
    """Judge effects (name, axis, probability) and a prediction against a truth."""
    case, answer, truth = tmp_path / "case", tmp_path / "answer", tmp_path / "truth.json"
    case.mkdir()
    answer.mkdir()
    time = np.linspace(0.0, 20.0, 400)
    measured = np.stack([np.sin(time) + 0.1 * np.sin(9.0 * time), np.cos(time)], axis=1)
    known = {"outer.torque_model": np.sin(time), "inner.torque_model": np.cos(time)}
    np.save(tmp_path / "truth.npy", measured)
    (case / "case.json").write_text(json.dumps({"axes": ["outer", "inner"]}))
    write_csv(case / "challenge.csv", known)

    def judge(told: list[tuple[str, str, float]], hidden: dict = TRUTH, right: bool = True) -> Score:
        truth.write_text(json.dumps(hidden))
        effects = [{"name": name, "axis": axis, "probability": p} for name, axis, p in told]
        (answer / "answer.json").write_text(json.dumps({"effects": effects}))
        outer = measured[:, 0] if right else known["outer.torque_model"]
        write_csv(answer / "torque.csv", {"outer.torque": outer, "inner.torque": measured[:, 1]})
        return score(truth, case, answer, 1.0)

    return judge


def test_the_right_name_is_exact_and_closes_the_gap(judged) -> None:  # type: ignore[no-untyped-def]
    one = judged([("cogging", "outer", 0.9)])
    assert one.exact and one.good and one.false_names == 0 and one.closed == pytest.approx(1.0)


def test_another_name_is_false_though_it_is_of_the_class(judged) -> None:  # type: ignore[no-untyped-def]
    one = judged([("cable_spring", "outer", 0.9)], right=False)
    assert not one.exact and one.of_class and one.false_names == 1 and one.closed == pytest.approx(0.0)


def test_who_cannot_tell_two_of_a_class_apart_has_the_class_and_no_name(judged) -> None:  # type: ignore[no-untyped-def]
    one = judged([("cogging", "outer", 0.45), ("cable_spring", "outer", 0.45)])
    assert one.of_class and not one.exact and one.false_names == 0
    assert not judged([("cogging", "outer", 0.3), ("cable_spring", "outer", 0.1)]).of_class
    assert not judged([("cogging", "outer", 0.9), ("inertia", "outer", 0.9)]).of_class


def test_a_right_name_beside_a_false_one_is_not_exact(judged) -> None:  # type: ignore[no-untyped-def]
    assert not judged([("cogging", "outer", 0.9), ("inertia", "inner", 0.6)]).exact


def test_the_axis_belongs_to_the_name(judged) -> None:  # type: ignore[no-untyped-def]
    assert judged([("cogging", "inner", 0.9)]).false_names == 1


def test_an_unlikely_name_is_not_said_but_counts_for_calibration(judged) -> None:  # type: ignore[no-untyped-def]
    one = judged([("inertia", "outer", 0.4)])
    assert one.abstained and one.false_names == 0 and one.told == ((0.4, False),)


def test_what_was_said_stands_in_a_picture_against_how_often_it_was_right(judged) -> None:  # type: ignore[no-untyped-def]
    scores = [judged([("cogging", "outer", 0.9)]), judged([("inertia", "outer", 0.8), ("viscous", "inner", 0.1)])]
    assert reliability(scores) == [(pytest.approx(0.1), 0.0, 1), (pytest.approx(0.85), 0.5, 2)]
    assert reliability([judged([])]) == []
    picture = drawn({"one": scores, "silent": [judged([])]})
    assert picture.count("<circle") == 2 and "3 names in 2 cases" in picture and "0 names in 1 cases" in picture


def test_silence_is_right_where_there_is_nothing(judged) -> None:  # type: ignore[no-untyped-def]
    assert judged([], NOTHING).good and not judged([("inertia", "outer", 0.9)], NOTHING).good
    counted = tally([judged([], NOTHING), judged([("inertia", "outer", 0.9)], NOTHING)])
    assert counted.false_on_nothing == 0.5 and counted.brier == pytest.approx(0.81)


def test_a_tool_that_leaves_nothing_has_not_answered_and_is_not_silent(tmp_path: Path) -> None:
    (tmp_path / "truth.json").write_text(json.dumps(NOTHING))
    one = score(tmp_path / "truth.json", tmp_path, tmp_path / "none", 1.0)
    assert not one.answered and not one.good


@pytest.mark.heavy
def test_two_adapters_answer_a_case_and_stand_in_a_table(tmp_path: Path) -> None:
    task = next(task for task in all_tasks() if task.name == "single.cogging.outer.0")
    case, truth = tmp_path / "cases" / task.name, tmp_path / "truth" / f"{task.name}.json"
    write_case(task, 0, case, truth)
    assert "outer.torque" not in read_csv(case / "challenge.csv")
    for tool in ("bic", "plain"):
        command = f"{sys.executable} -m tests.benchmarks.naming.rivals.{tool} {{case}} {{answer}}"
        answered(command, case, tmp_path / "answers" / tool / task.name)
    (bic,) = scores_of(tmp_path, "bic", [task])
    assert bic.answered and bic.closed is not None and bic.closed > 0.5
    assert "`bic`" in table(tmp_path, [task]) and "`plain`" in table(tmp_path, [task])
