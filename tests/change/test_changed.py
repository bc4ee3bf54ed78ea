"""What changed between two sets of logs is told by name, and nothing else is."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from gimbal_hil.data.signals import SignalsTable, write_signals
from gimbal_hil.knowledge.change import CHANGED_SCHEMA, AskedCause, Heard
from gimbal_hil.knowledge.change.comparing import ChangeKind, Left, MachineComparison, _liked_best
from gimbal_hil.knowledge.change.one_gain import as_one_gain
from gimbal_hil.knowledge.change.telling import text_of
from gimbal_hil.knowledge.discrepancy import Kind, Status, standing
from gimbal_hil.surface.cli.app import run
from sim_backend.model import shipped_model
from tests.benchmarks.what_changed import draw, right
from tests.cases.joint import BENCH
from tests.change.rig import Machine

#: what a person believes of the machine: every number somewhat off
BELIEVED = Machine(inertia=0.0212, coulomb=0.045, viscous=0.023)
KEYS = {
    "schema", "verdict", "text", "effects", "alternatives", "dismissed", "shared", "something_else", "moved", "left",
    "smallest_shown", "not_testable", "before", "after", "notes",
}  # fmt: skip


@pytest.mark.parametrize(
    ("after", "before", "heard"),
    [
        ((9.0, 1.0), (1.0, 60.0), Heard.AGAINST),
        ((9.0, 1.0), (1.0, 3.1), Heard.AGAINST),
        ((9.0, 1.0), (9.0, 1.2), Heard.SHARED),
        ((9.0, 1.0), (1.0, 1.01), Heard.DEAF),
        ((1.4, 1.0), (1.0, 1.2), Heard.DEAF),
        # it grew: the logs before like it better than none of it, and half of it far better
        ((42.0, 1.0), (6.7, 5.0, 1.0), Heard.AGAINST),
    ],
)
def test_a_cause_is_a_change_where_the_logs_before_lose_by_it(
    after: tuple[float, float], before: tuple[float, ...], heard: Heard
) -> None:
    asked = AskedCause(("coulomb", "joint"), Status.NAMED, after, before[:2], 0.5, min(before))  # type: ignore[arg-type]
    assert asked.heard is heard


@pytest.mark.parametrize(
    ("after", "with_them", "kind"),
    # the last: logs that are noisier whatever the numbers are
    [(1.2, 0.9, ChangeKind.NO_CHANGE), (4.4, 0.9, ChangeKind.AMBIGUOUS), (1.45, 1.4, ChangeKind.NO_CHANGE)],
)
def test_numbers_that_moved_within_what_is_known_are_told_where_the_logs_ask_for_it(
    after: float, with_them: float, kind: ChangeKind
) -> None:
    model = BELIEVED.model()
    moved = {"axis": "joint", "path": "body.inertia.zz", "from": 0.02, "to": 0.0197, "low": 0.0196, "high": 0.0198}
    unmoved = {**moved, "path": "friction.viscous", "from": 0.0198}
    shown = {"name": "inertia", "axis": "joint", "relative": 0.024}
    found = SimpleNamespace(kind=Kind.NO_DISCREPANCY, recalibrated=(moved, unmoved), smallest_shown=(shown,))
    left = (Left("joint", "torque", 0.9, after, with_them),)
    told = MachineComparison(model, model, (), (), found, found, None, left)  # type: ignore[arg-type]
    assert told.kind is kind and told.moved == ((moved,) if kind is ChangeKind.AMBIGUOUS else ())
    assert ("was 0.02 kg m2 and is 0.0197 kg m2" in text_of(told)) is bool(told.moved)
    assert ("inertia of joint 2.4%" in text_of(told)) is not bool(told.moved)


def test_the_schema_has_every_key_and_refuses_what_no_answer_says() -> None:
    jsonschema = pytest.importorskip("jsonschema", reason="jsonschema is not installed (the extra test has it)")
    jsonschema.Draft202012Validator.check_schema(CHANGED_SCHEMA)
    assert set(CHANGED_SCHEMA["required"]) == set(CHANGED_SCHEMA["properties"]) == KEYS
    seen = {error.json_path for error in against_schema({"verdict": "better", "schema": 2, "effects": [{}]})}
    assert {"$.verdict", "$.schema", "$.effects[0]"} <= seen


def against_schema(answer: dict[str, object]) -> list:
    jsonschema = pytest.importorskip("jsonschema", reason="jsonschema is not installed (the extra test has it)")
    return list(jsonschema.Draft202012Validator(CHANGED_SCHEMA).iter_errors(answer))


def test_the_share_that_is_liked_best_lies_at_the_bottom_of_a_parabola() -> None:
    def left(share: float) -> float:
        return 1.0 + 4.0 * (share - 0.55) ** 2

    share, least = _liked_best(left(0.0), left(0.5), left(1.0))
    assert share == pytest.approx(0.55) and least == pytest.approx(1.0)
    assert _liked_best(2.0, 2.0, 2.0) == (0.0, 2.0)


def number(name: str, before: float, after: float, share: float = 0.01) -> dict[str, object]:
    value = {"value": after, "low": after * (1.0 - share), "high": after * (1.0 + share), "nominal": before}
    return {"name": name, "axis": "joint", "probability": 0.97, "parameters": {name: value}}


def test_numbers_that_one_factor_changed_are_told_as_a_gain() -> None:
    numbers = [
        number("inertia", 0.02, 0.02 / 1.15),
        number("coulomb", 0.05, 0.05 / 1.15),
        number("viscous", 0.02, 0.0175),
    ]
    found, others = as_one_gain([*numbers, number("cogging", 0.0, 0.01)], 0.02)
    assert [entry["name"] for entry in found] == ["torque_gain", "cogging"] and len(others) == 3
    gain = found[0]["parameters"]["gain_error"]
    assert gain["low"] < 0.15 < gain["high"]
    apart = [*numbers[:2], number("viscous", 0.02, 0.02)]
    assert as_one_gain(apart, 0.02) == (apart, []) and as_one_gain(numbers[:2], 0.02) == (numbers[:2], [])


def answer(
    folder: Path, before: Machine, after: Machine, seed: int, *words: str, count: int = 2
) -> tuple[int, dict[str, object]]:
    """The exit code of the command on logs of two machines, and what it leaves."""
    random = np.random.default_rng(seed)
    names: dict[str, list[str]] = {"--before": [], "--after": []}
    for (option, some), machine in zip(names.items(), (before, after), strict=True):
        for place, table in enumerate(machine.logs(random, count)):
            some.append(str(folder / f"{option[2:]}{place}.csv"))
            write_signals(table, Path(some[-1]))
    (folder / "model.yaml").write_text(BELIEVED.model().to_yaml())
    logs = [word for option, some in names.items() for word in (option, *some)]
    out = ["--model", str(folder / "model.yaml"), "--out", str(folder / "out"), "--workers", "1"]
    code = run("changed", [*logs, *out, *words])
    found = json.loads((folder / "out" / "changed.json").read_text())
    assert not against_schema(found)
    return code, found


@pytest.mark.heavy
def test_a_changed_level_and_a_new_ripple_are_told_with_what_was_before(tmp_path: Path) -> None:
    code, found = answer(tmp_path, Machine(), Machine(coulomb=0.065, ripple=0.01), 77, "--fail-on", "changed")
    assert code == 1 and found["verdict"] == "changed" and set(found) == KEYS, found["text"]
    told = {entry["name"]: entry for entry in found["effects"]}  # type: ignore[union-attr, attr-defined]
    assert set(told) == {"coulomb", "cogging"}
    level = told["coulomb"]["parameters"]["coulomb"]
    assert level["nominal"] == pytest.approx(0.05, rel=0.02) and level["value"] == pytest.approx(0.065, rel=0.02)
    assert told["cogging"]["parameters"]["amplitude"]["value"] == pytest.approx(0.01, rel=0.05)
    assert all(entry["left_before"]["with"] > 2.0 * entry["left_before"]["without"] for entry in told.values())
    page = (tmp_path / "out" / "report.html").read_text()
    assert "What changed" in page and "cogging (joint)" in page and (tmp_path / "out" / "model_before.yaml").exists()


@pytest.mark.heavy
def test_what_the_model_lacks_on_both_sides_is_no_change(tmp_path: Path) -> None:
    machine = Machine(ripple=0.012, order=9.0)
    code, found = answer(tmp_path, machine, machine, 5)
    assert code == 0 and found["verdict"] == "no_change" and not found["effects"], found["text"]
    assert "cogging" in [entry["name"] for entry in found["shared"]]  # type: ignore[union-attr, attr-defined]


@pytest.mark.heavy
def test_an_encoder_whose_scale_is_off_by_a_little_is_no_all_clear(tmp_path: Path) -> None:
    class Swinging(Machine):
        def logs(self, random: np.random.Generator, count: int = 2) -> tuple[SignalsTable, ...]:
            logs = [BENCH.log(which, 20.0, seed=int(random.integers(999))) for which in "ab"[:count]]
            sides = [{"joint.torque": log.torque, "joint.position": self.gain * log.position} for log in logs]
            return tuple(SignalsTable.of(("joint",), logs[0].time, side, source="log") for side in sides)

    _, found = answer(tmp_path, Swinging(), Swinging(gain=1.015), 9)
    assert found["verdict"] == "ambiguous" and (found["moved"] or found["effects"]), found["text"]


@pytest.mark.heavy
def test_a_single_log_on_each_side_will_do(tmp_path: Path) -> None:
    _, found = answer(tmp_path, Machine(), Machine(gain=0.8), 8, count=1)
    assert found["verdict"] in ("changed", "ambiguous") and found["effects"], found["text"]


def test_one_log_on_both_sides_and_a_verdict_that_is_none_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "log.csv"
    write_signals(Machine().log(np.random.default_rng(1), 5.0), log)
    (tmp_path / "model.yaml").write_text(BELIEVED.model().to_yaml())
    words = ["--before", str(log), "--after", str(log), "--model", str(tmp_path / "model.yaml")]
    for more, said in (([], "is before and after"), (["--fail-on", "named"], "'named' is no verdict")):
        with pytest.raises(SystemExit) as refused:
            run("changed", [*words, *more, "--out", str(tmp_path / "out")])
        assert refused.value.code == 2 and said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.heavy
def test_a_ripple_that_grew_is_told_with_the_share_that_was_there(tmp_path: Path) -> None:
    before = Machine(inertia=0.025, coulomb=0.042, viscous=0.023, ripple=0.0113)
    code, found = answer(tmp_path, before, before.but(ripple=0.0206), 8000)
    assert code == 0 and found["verdict"] == "changed", found["text"]
    (cogging,) = found["effects"]  # type: ignore[misc]
    assert cogging["name"] == "cogging"
    # either side of a search that told the ripple before or did not: what changed is the difference
    grown = cogging["parameters"]["amplitude"]["value"] * (1.0 - cogging["share_before"])
    assert grown == pytest.approx(0.0093, rel=0.15)


@pytest.mark.heavy
@pytest.mark.parametrize("factor", [1.0, 1.3])
def test_runs_of_an_antenna_of_two_axes_are_compared_as_they_lie(tmp_path: Path, factor: float) -> None:
    """Run folders of the virtual antenna; what is other after is the outer axis' friction, or nothing."""
    model = shipped_model()
    names = ("friction.coulomb", "friction.breakaway")
    levels = {name: factor * model.number("outer", name) for name in names}
    (tmp_path / "other.yaml").write_text(model.with_numbers("outer", levels).to_yaml())
    sides: dict[str, list[str]] = {"--before": [], "--after": []}
    for seed, (option, logs) in enumerate(sides.items()):
        for place, sequence in enumerate(("survey", "survey_holdout")):
            folder = str(tmp_path / f"{option[2:]}{place}")
            of = ["--model", str(tmp_path / "other.yaml")] if option == "--after" else []
            assert run("experiment", [sequence, "--short", "--seed", str(10 * seed + place), "--out", folder, *of]) == 0
            logs.append(folder)
    words = [word for option, logs in sides.items() for word in (option, *logs)]
    only = ["--only", "coulomb", "--only", "viscous", "--only", "cogging"]
    assert run("changed", [*words, *only, "--out", str(tmp_path / "out"), "--workers", "1"]) == 0
    found = json.loads((tmp_path / "out" / "changed.json").read_text())
    told = [(entry["name"], entry["axis"]) for entry in found["effects"]]
    assert told == ([] if factor == 1.0 else [("coulomb", "outer")]), found["text"]
    assert found["verdict"] == ("no_change" if factor == 1.0 else "changed"), found["text"]


@pytest.mark.heavy
def test_a_change_below_the_usual_limit_is_told_where_the_logs_before_are_quieter_than_it() -> None:
    """A ripple of 8.6 mN m leaves 1.48 floors, and the logs before leave 0.78."""
    found = draw("ripple", 9502)
    assert right(found), found


def test_what_a_model_leaves_of_a_log_is_weighed_as_in_a_verdict_where_friction_turns() -> None:
    machine = Machine()
    table = machine.log(np.random.default_rng(7))
    without_bristles = machine.model().with_numbers("joint", {"friction.sigma0": 0.0, "friction.sigma1": 0.0}, None)
    (gap,) = standing(without_bristles, table)
    assert gap["before"] < 1.5 * gap["noise_floor"]
