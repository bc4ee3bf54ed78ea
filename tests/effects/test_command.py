"""`gimbal-hil effects` prints the whole catalogue, for people and for tools."""

from __future__ import annotations

import json

import pytest

from gimbal_hil.cli.effects import as_document, command
from sim_backend.effects import CATALOGUE


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
