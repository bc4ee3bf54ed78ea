"""Joints of other simulators that were once told wrongly (decisions 68 and 69)."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.rigs import drawn, worn


@pytest.mark.parametrize(("name", "motion", "seed"), [("9-45", "sweeps", 9045), ("10-62", "turns", 10062)])
def test_a_gain_is_not_three_numbers_that_are_off_alike(name: str, motion: str, seed: int, tmp_path: Path) -> None:
    said = drawn.asked(tmp_path, name, "gain", motion, seed)
    assert [one["name"] for one in said["verdict"]["effects"]] == ["torque_gain"]
    assert said["verdict"]["verdict"] == "named" and said["judged"] == "right"


def test_a_curve_over_position_takes_no_name_from_an_inertia(tmp_path: Path) -> None:
    said = worn.asked(tmp_path, "2-08", "inertia halved", "a ripple", "sines", 2008)
    assert [(one["name"], one["status"]) for one in said["verdict"]["effects"]] == [("inertia", "named")]
    assert said["judged"] == "right"


def test_two_causes_that_act_against_each_other_in_half_of_the_data_are_found_together(tmp_path: Path) -> None:
    said = worn.asked(tmp_path, "3024", "dry friction doubled", "gravity", "moves", 3024)
    verdict = said["verdict"]
    named = {one["name"] for one in verdict["effects"] if one["status"] == "named"}
    told = {one["name"] for one in (*verdict["effects"], *verdict["alternatives"])}
    assert "coulomb" in named and "static_unbalance" in told
    # what a ripple of one turn is called
    assert told <= {"coulomb", "static_unbalance", "cogging", "cable_spring", "presliding", "stribeck"}


def test_a_rival_is_compared_where_the_other_causes_have_not_stood_in_for_both(tmp_path: Path) -> None:
    # without either, a soft bristle pulled back like a spring, and an unbalance found no way from there
    said = worn.asked(tmp_path, "3-29", "inertia halved", "gravity", "moves", 3029)
    named = {one["name"] for one in said["verdict"]["effects"] if one["status"] == "named"}
    assert {"static_unbalance", "inertia"} <= named and "cable_spring" not in named
