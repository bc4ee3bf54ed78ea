"""Every command ends with one whole command line that the program itself understands."""

from __future__ import annotations

import inspect
import shlex
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import typer.main

from firmware_protocol.errors import BadInputError
from gimbal_hil.surface.checking import Checked, FileKind, check_files
from gimbal_hil.surface.cli import following, following_logs, next_line
from gimbal_hil.surface.cli.changed import ComparedLogs
from gimbal_hil.surface.cli.commands import COMMANDS, function_of
from gimbal_hil.surface.cli.completion import whole_app
from gimbal_hil.surface.cli.log_options import LogOptions, SearchOptions

OPEN: dict[str, Any] = {"effects": [{"name": "cogging"}], "alternatives": [], "where": [], "next_experiment": None}
HERE = Path("runs/one")
COMPARED = ComparedLogs([Path("a.csv")], [Path("b.csv")], Path("out/changed"), "m.yaml")


def checked(name: str, kind: FileKind, moves: bool = True, fault: bool = False) -> Checked:
    return Checked(Path(name), kind, "", (BadInputError("here", "is wrong", "right"),) if fault else (), moves)


LINES = [
    following.after_demo(),
    following.after_check([Path("a.yaml")], [checked("a.yaml", FileKind.MODEL, fault=True)], ["a.b=c d:deg"]),
    following.after_check(
        [Path("m.yaml")], [checked("m.yaml", FileKind.MODEL), checked("c.yaml", FileKind.CONFIGURATION)]
    ),
    following.after_check([HERE], [checked("runs/one", FileKind.RUN)]),
    following.after_check([HERE], [checked("a.csv", FileKind.SIGNALS)], ["time_s=t", "AXIS.position=q"]),
    following.after_check([HERE], [checked("a.csv", FileKind.SIGNALS)], ["time_s=t [ms]:ms"]),
    following.after_check([HERE], [checked("a.csv", FileKind.SIGNALS)], ["a.b=c"], {"rate": "500", "repair": True}),
    following.after_check([Path("a.csv")], [checked("a.csv", FileKind.SIGNALS, fault=True)], [], {"rate": "500"}),
    following.after_daemon(HERE, 0),
    following.after_conformance(None, None),
    following.after_conformance(Path("c.yaml"), HERE),
    following.after_plant(Path("c.yaml"), "unix", "/tmp/a"),
    following.after_plant(None, "serial", "/dev/pts/3"),
    following_logs.after_identify(Path("out/friction"), [HERE], 2, True),
    following_logs.after_identify(Path("out/friction"), [HERE], 2, False),
    following_logs.after_identify(Path("out/friction"), [HERE, HERE], 1, True, ["time_s=t [ms]:ms"]),
    following_logs.after_identify(
        Path("out/friction"), [HERE], 1, False, ["j.position=q:rad"], ["j"], "m.yaml", {"rate": "500"}
    ),
    following_logs.after_identify(
        Path("out/friction"), [HERE], 1, True, (), (), None, {"repair": True, "resample": False}
    ),
    following_logs.after_discrepancy(OPEN | {"verdict": "unexplained"}, "emps", 2, Path("out/verdict")),
    following_logs.after_discrepancy(OPEN | {"verdict": "named"}, None, 2, Path("out/verdict")),
    following_logs.after_discrepancy(OPEN | {"verdict": "ambiguous"}, None, 1, Path("out/verdict")),
    following_logs.after_discrepancy(OPEN | {"verdict": "ambiguous"}, None, 2, Path("out/verdict"), (), Path(__file__)),
    following_logs.after_discrepancy(OPEN | {"verdict": "cannot_judge"}, None, 2, Path("out/verdict")),
    following.after_export_model(Path("m.yaml"), 2),
    following.after_export_model(Path("m.yaml"), 1),
    following_logs.after_testable("survey", "m.yaml", None, True),
    following_logs.after_testable("survey", "m.yaml", Path("c.yaml"), False),
    following.after_joint("elbow", 0.41, Path("elbow.csv")),
    *(
        following_logs.after_changed(found, COMPARED, LogOptions(["a.b=c"], rate=500.0), search, axes)
        for found in (
            OPEN | {"verdict": "changed"},
            *(OPEN | {"effects": [], "verdict": kind} for kind in ("no_change", "cannot_judge", "ambiguous")),
        )
        for search in (SearchOptions(), SearchOptions(only=["cogging"]))
        for axes in (1, 2)
    ),
    following_logs.after_improve(Path("better"), None, True),
    following_logs.after_improve(Path("better"), Path("c.yaml"), False),
    following_logs.after_improve(Path("better"), None, True, None, ["viscous"]),
    following.after_tune(Path("c.yaml"), Path("c.tuned.yaml"), "realistic", 2),
    following.after_tune(Path("c.yaml"), Path("c.tuned.yaml"), "emps", 1),
    following.after_replay(HERE, True),
    following.after_certificate(12, HERE, None, {"seed": 1}),
    following.after_certificate(10_000, HERE, Path("c.yaml"), {}),
    following.after_export(HERE, Path("a.csv"), True, ("outer", "inner")),
    following.after_drive_tables(Path("m.yaml"), Path("c.yaml"), Path("tables"), False),
    following.after_drive_tables(Path("m.yaml"), Path("c.yaml"), Path("tables"), True),
    following.after_effects(None, None),
    following.after_effects("cogging", "full_turn"),
    following.after_campaign("step", 12, Path("c"), {"spread": ["all=5%"], "short": True, "seed": 0}),
    following.after_campaign("step", 1000, Path("c"), {"spread": ["all=5%"], "seed": 0}),
    following.closer_to_speed(9, None),
    following.closer_to_speed(27, Path("b")),
    following.closer_to_faults("c"),
    following.closer_to_soak("serial"),
    following.closer_to_soak(None),
    following.closer_to_trip("thesis", "realistic", "steps: 0.1 rad"),
    following.after_bench(False, "gimbal-hil bench faults", Path("c.yaml")),
    following.after_doctor(None, False),
    following.after_doctor(Path("c.yaml"), True),
    following.after_doctor(Path("c.yaml"), False, True, True),
    following.after_doctor(Path("c.yaml"), True, False),
]


def test_positions_that_seem_to_be_in_turns_are_asked_again_in_turns() -> None:
    words = ["time_s=t", "j.position=pos", "k.position=a b:deg"]
    assert following_logs.columns_in_turns(words, ["j", "k"]) == [
        "time_s=t",
        "j.position=pos:turn",
        "k.position=a b:turn",
    ]
    assert following_logs.columns_in_turns((), ["j"]) == ["j.position=j.position:turn"]
    words = ["j.position=/odrv0:pos", "k.position=enc:-rad"]
    assert following_logs.columns_in_turns(words, ["j", "k"]) == ["j.position=/odrv0:pos:turn", "k.position=enc:-turn"]


def test_a_log_of_axes_that_no_model_has_leads_to_a_model_of_them() -> None:
    elbow = Checked(Path("log.csv"), FileKind.SIGNALS, "", unmodelled=("elbow",))
    assert following.after_check([Path("log.csv")], [elbow]).endswith("--yes --kind rotary --axes elbow")
    both = replace(elbow, unmodelled=("pan", "tilt"))
    assert following.after_check([Path("log.csv")], [both]).endswith("--yes --kind gimbal --axes pan,tilt")
    beside = [elbow, checked("m.yaml", FileKind.MODEL)]
    assert following.after_check([Path("log.csv")], beside).startswith("gimbal-hil identify log.csv --model m.yaml")


def test_several_logs_beside_a_model_lead_to_a_verdict_that_the_last_one_judges() -> None:
    logs = [Checked(Path(f"{name}.csv"), FileKind.SIGNALS, "") for name in "abc"]
    said = following.after_check([], [*logs, checked("m.yaml", FileKind.MODEL)], ["j.position=q:deg"])
    assert said == (
        "gimbal-hil discrepancy --model m.yaml --measured a.csv --measured b.csv --holdout c.csv "
        "--column j.position=q:deg --out verdict"
    )


def test_an_improved_model_whose_friction_its_logs_would_not_show_leads_to_friction() -> None:
    assert " experiment sliding " in following_logs.after_improve(
        Path("better"), None, True, None, ["viscous", "inertia"]
    )
    assert " experiment survey " in following_logs.after_improve(Path("better"), None, True, None, ["inertia"])
    assert " experiment step " in following_logs.after_improve(Path("better"), None, True, HERE)


@pytest.mark.parametrize("line", LINES)
def test_what_is_proposed_is_a_command_with_options_that_it_has(line: str) -> None:
    program, name, *words = shlex.split(line)
    assert program == "gimbal-hil" and name in COMMANDS
    command = typer.main.get_command(whole_app()).commands[name]  # type: ignore[attr-defined]
    command.make_context(name, words)


def test_every_command_says_what_comes_next() -> None:
    silent = [name for name in COMMANDS if "print_next" not in (inspect.getsource(function_of(name)[0]))]
    assert not silent


@pytest.mark.parametrize(
    ("planned", "regime", "expected"),
    [
        ("two constant speeds (gimbal-hil experiment full_turn)", "rate > 1 rad/s", "full_turn"),
        (None, "position 0.10..0.40 rad", "full_turn"),
        (None, "rate < 0.01 rad/s", "creep"),
        (None, "rate > 0.2 rad/s", "plateaus"),
        (None, "warmer than 31.0 degC", "warm_and_cool"),
        (None, "everywhere", "reversals"),
    ],
)
def test_an_open_verdict_proposes_the_planned_run_or_one_that_dwells_where_the_gap_is(
    planned: str | None, regime: str, expected: str
) -> None:
    verdict = OPEN | {
        "verdict": "unexplained",
        "where": [{"regime": regime}],
        "next_experiment": None if planned is None else {"plan": planned},
    }
    assert following_logs.after_discrepancy(verdict, None, 2, Path("v")).startswith(
        f"gimbal-hil experiment {expected} "
    )


def test_numbers_that_nobody_measured_are_measured_where_they_keep_logs_from_judging() -> None:
    line = following_logs.after_discrepancy(
        OPEN | {"verdict": "cannot_judge"}, "m.yaml", 2, Path("v"), assumed={"viscous", "inertia"}
    )
    assert line == "gimbal-hil experiment sliding --known m.yaml --out sliding"
    inertia = following_logs.after_discrepancy(
        OPEN | {"verdict": "cannot_judge"}, "m.yaml", 2, Path("v"), assumed={"inertia"}
    )
    assert inertia == "gimbal-hil check m.yaml"
    measured = following_logs.after_discrepancy(OPEN | {"verdict": "cannot_judge"}, "m.yaml", 2, Path("v"))
    assert measured.startswith("gimbal-hil experiment survey ")


@pytest.mark.parametrize("verdict", ["ambiguous", "cannot_judge"])
def test_an_open_verdict_proposes_the_motion_that_was_made_for_it(verdict: str, tmp_path: Path) -> None:
    made, found = tmp_path / "settle.yaml", OPEN | {"verdict": verdict}
    assert "settle" not in following_logs.after_discrepancy(found, None, 2, tmp_path / "v", (), made)
    made.write_text("", encoding="utf-8")
    line = following_logs.after_discrepancy(found, None, 2, tmp_path / "v", (), made)
    assert line == f"gimbal-hil experiment {made} --out {tmp_path / 'settle'}"


def test_logs_of_which_some_effects_alone_were_searched_are_compared_again() -> None:
    nothing, search = OPEN | {"effects": [], "verdict": "cannot_judge"}, SearchOptions(only=["cogging"])
    assert following_logs.after_changed(nothing, COMPARED, LogOptions(), search, 1) == (
        "gimbal-hil changed --model m.yaml --before a.csv --after b.csv --out out/changed_of_all"
    )
    whole = following_logs.after_changed(nothing, COMPARED, LogOptions(), SearchOptions(), 1)
    assert whole == "gimbal-hil discrepancy --model m.yaml --measured a.csv --out out/verdict"
    assert " experiment survey " in following_logs.after_changed(nothing, COMPARED, LogOptions(), SearchOptions(), 2)


@pytest.mark.parametrize(
    ("verdict", "expected"),
    [("described", "check v/model.yaml"), ("no_discrepancy", "check m.yaml"), ("cannot_judge", "check m.yaml"),
     ("unexplained", "effects")],
)  # fmt: skip
def test_on_one_axis_a_verdict_without_a_name_leads_to_the_model_it_is_of(verdict: str, expected: str) -> None:
    nameless = OPEN | {"effects": [], "verdict": verdict}
    assert following_logs.after_discrepancy(nameless, "m.yaml", 1, Path("v")) == f"gimbal-hil {expected}"


def test_an_antenna_that_does_not_answer_is_rehearsed_or_looked_for_again(tmp_path: Path) -> None:
    config = tmp_path / "antenna.yaml"
    assert following.after_doctor(config, True, False) == f"gimbal-hil doctor --config {config}"
    rehearsal = tmp_path / "rehearsal.yaml"
    rehearsal.write_text("", encoding="utf-8")
    assert following.after_doctor(config, False, False).startswith(f"gimbal-hil experiment step --config {rehearsal} ")
    assert "--lockstep" in following.after_doctor(config, False)


def test_a_target_that_was_missed_is_looked_at_closer_and_not_looked_for_in_the_machine(tmp_path: Path) -> None:
    assert following.closer_to_speed(9, None) == "gimbal-hil bench speed --repeats 27 --out bench"
    assert following.closer_to_speed(9, Path("b")).endswith(" --out b --force")
    assert following.closer_to_speed(27, None) == "gimbal-hil bench realtime"
    assert following.after_bench(True, "gimbal-hil bench faults", None) == "gimbal-hil bench faults"
    for missed, closer in ((False, "gimbal-hil bench faults"), (True, "")):
        assert following.after_bench(missed, closer, None) == "gimbal-hil doctor"
    config = tmp_path / "antenna.yaml"
    config.write_text("", encoding="utf-8")
    tuned = following.closer_to_trip(str(config), "realistic", "steps")
    assert tuned.startswith(f"gimbal-hil tune --config {config} --model realistic")
    assert following.closer_to_trip("thesis", "realistic", "steps").startswith("gimbal-hil bench pointing --controller")


def test_names_with_blanks_are_quoted_as_a_shell_wants_them() -> None:
    assert next_line.command_line("replay", Path("my runs/1")) == "gimbal-hil replay 'my runs/1'"


MODELS = sorted((Path(following.__file__).parents[3] / "config" / "models").glob("*.yaml"))
ONES_OWN: dict[str, tuple[str, ...]] = {
    "a gimbal": (),
    "on an air bearing": ("--coulomb", "azimuth=0", "--viscous", "azimuth=0"),
    "one joint": ("--kind", "rotary"),
    "a slide": ("--kind", "linear"),
    "behind a link": ("--link", "unix:/tmp/nobody"),
    "drives": ("--link", "moteus:can0"),
}


def next_of(*words: str, folder: Path) -> list[str]:
    """What a command proposes, taken apart."""
    program = str(Path(sys.executable).with_name("gimbal-hil"))
    done = subprocess.run([program, *words], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return shlex.split(done.stdout.splitlines()[-1].removeprefix("next: gimbal-hil "))


def test_a_model_of_one_axis_is_not_sent_to_an_experiment() -> None:
    (emps,) = (model for model in MODELS if model.stem == "emps")
    assert following.after_check([emps], check_files([emps])) == "gimbal-hil effects"


def test_a_configuration_on_a_link_is_not_sent_to_virtual_time() -> None:
    one = [checked("a.yaml", FileKind.CONFIGURATION, moves=False), checked("plan.yaml", FileKind.PLAN)]
    assert following.after_check([Path("a.yaml")], one) == "gimbal-hil doctor --config a.yaml"
    rehearsed = [*one, checked("rehearsal.yaml", FileKind.CONFIGURATION)]
    assert following.after_check([Path(".")], rehearsed).endswith("experiment plan.yaml --config rehearsal.yaml")


@pytest.mark.heavy
@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.stem)
def test_what_check_proposes_for_a_shipped_model_runs(model: Path, tmp_path: Path) -> None:
    next_of(*next_of("check", str(model), folder=tmp_path), folder=tmp_path)


@pytest.mark.heavy
@pytest.mark.parametrize("options", ONES_OWN.values(), ids=ONES_OWN)
def test_what_check_proposes_for_ones_own_files_runs(options: tuple[str, ...], tmp_path: Path) -> None:
    next_of("init", "mine", "--yes", *options, folder=tmp_path)
    for file in ("mine", "mine/model.yaml", *(f"mine/{name}.yaml" for name in ("plan",) if "--kind" not in options)):
        proposed = next_of("check", file, folder=tmp_path)
        assert proposed[0] in ("experiment", "effects", "check"), proposed
        next_of(*proposed, folder=tmp_path)
