"""`gimbal-hil effects` prints the whole catalogue, for people and for tools."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from gimbal_hil.surface.cli.effects import as_document, command
from sim_backend.effects import CATALOGUE, Effect, confused_with
from sim_backend.effects.separating_runs import RUNS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "reference" / "effects.md"


def test_every_effect_and_parameter_is_printed_with_unit_and_run(capsys: pytest.CaptureFixture[str]) -> None:
    assert command() == 0
    printed = capsys.readouterr().out
    for effect in CATALOGUE.values():
        assert f"  {effect.name} " in printed and effect.excited_by in printed and effect.source in printed
        for parameter in effect.parameters:
            assert f"      {parameter.name} " in printed and parameter.unit in printed


def test_the_json_form_is_one_object_with_every_effect(capsys: pytest.CaptureFixture[str]) -> None:
    assert command(as_json=True) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == 1
    assert {effect["name"] for effect in document["effects"]} == set(CATALOGUE)


def test_one_effect_can_be_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    assert command("backlash") == 0
    printed = capsys.readouterr().out
    assert "rotor_inertia" in printed and "cogging" not in printed


def test_a_number_of_the_model_has_no_neutral_value() -> None:
    assert as_document(CATALOGUE["viscous"])["parameters"][0]["neutral"] is None
    assert as_document(CATALOGUE["cogging"])["parameters"][0]["neutral"] == 0.0


def test_the_command_says_what_an_effect_acts_through_needs_and_is_told_apart_by(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert command("gyro_misalignment") == 0
    printed = capsys.readouterr().out
    assert "acts through: base motion, position, rate" in printed and "needs: gyro, moving base" in printed
    assert "drive one axis with the other locked" in printed
    document = as_document(CATALOGUE["cogging"])
    assert (
        document["confused_with"] == list(confused_with("cogging"))
        and document["separated_by"][0]["experiment"] == "full_turn"
    )


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=lambda effect: effect.name)
def test_the_page_of_effects_says_what_the_catalogue_says(effect: Effect) -> None:
    through, needs = (
        ", ".join(words) or "-"
        for words in (sorted(v.value for v in effect.acts_through), [n.text for n in effect.needs])
    )
    runs = ", ".join(f"R{RUNS.index(run) + 1}" for run in effect.separated_by) or "-"
    assert f"| `{effect.name}` | {through} | {needs} | {runs} |" in PAGE.read_text(encoding="utf-8")


@pytest.mark.parametrize("place", range(len(RUNS)))
def test_the_page_of_effects_numbers_the_runs_and_names_the_experiment_of_each(place: int) -> None:
    run = RUNS[place]
    made_by = f"`{run.sequence}`" if run.sequence else "by hand"
    assert f"| R{place + 1} | {run.text} | {made_by} |" in PAGE.read_text(encoding="utf-8")
