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
from tests.benchmarks.naming.run import answered, scores_of, table
from tests.benchmarks.naming.scoring import Score, score, tally
from tests.benchmarks.naming.tables import read_csv, write_csv
from tests.blind.causes import catalogue, outside

ROOT = Path(__file__).resolve().parents[3]
PACKAGE = Path(__file__).parent


def test_nothing_of_the_product_is_imported() -> None:
    modules = [
        ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for path in sorted(PACKAGE.rglob("*.py"))
        if path.name not in ("test_naming.py", "sindy.py", "narmax.py", "genetic.py", "operon.py")
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


def test_a_right_name_beside_a_false_one_is_not_exact(judged) -> None:  # type: ignore[no-untyped-def]
    assert not judged([("cogging", "outer", 0.9), ("inertia", "inner", 0.6)]).exact


def test_the_axis_belongs_to_the_name(judged) -> None:  # type: ignore[no-untyped-def]
    assert judged([("cogging", "inner", 0.9)]).false_names == 1


def test_an_unlikely_name_is_not_said_but_counts_for_calibration(judged) -> None:  # type: ignore[no-untyped-def]
    one = judged([("inertia", "outer", 0.4)])
    assert one.abstained and one.false_names == 0 and one.told == ((0.4, False),)


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
