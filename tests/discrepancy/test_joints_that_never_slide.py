"""A joint that only moves on its bristles: their stiffness is told, and nothing else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.rigs.presliding import BREAKAWAY, SIGMA0, write_presliding
from tests.rigs.told import Row, ask


def verdict_of(folder: Path, factors: dict[str, float], bristle: bool = True) -> dict[str, Any]:
    """What the command says of two logs and this model."""
    rig = write_presliding(folder, factors, bristle)
    found: dict[str, Any] = ask(Row("joint", rig, ("first",), ("second",), ""), folder / "out")["verdict"]
    return found


@pytest.mark.parametrize("factor", [0.5, pytest.param(2.0, marks=pytest.mark.heavy)])
def test_a_stiffness_that_is_wrong_is_named_alone(factor: float, tmp_path: Path) -> None:
    verdict = verdict_of(tmp_path, {"friction.sigma0": factor})
    assert [one["name"] for one in verdict["effects"]] == ["presliding"]
    assert verdict["verdict"] == "named"
    assert verdict["effects"][0]["parameters"]["sigma0"]["value"] == pytest.approx(SIGMA0, rel=0.04)
    # what such a joint does within its bristles is no torque column of another time
    assert not verdict["contradictions"], verdict["contradictions"]


@pytest.mark.heavy
def test_how_bristles_bend_shows_a_level_that_is_wrong_or_a_gain(tmp_path: Path) -> None:
    """The model of a stranger has neither bristle nor break-away: a level of 0.7 N m in place of 0.5 bends the bristles
    as a torque constant would that is less by as much.
    """
    verdict = verdict_of(tmp_path, {}, bristle=False)
    told = {one["name"]: one["status"] for one in verdict["effects"]}
    assert told == {"presliding": "named", "torque_gain": "ambiguous"} and verdict["verdict"] == "ambiguous"
    level = next(one for one in verdict["alternatives"] if one["name"] == "coulomb")["parameters"]["coulomb"]
    assert level["value"] == pytest.approx(BREAKAWAY, rel=0.02)
    assert not verdict["contradictions"], verdict["contradictions"]


@pytest.mark.heavy
@pytest.mark.parametrize("factors", [{}, {"body.inertia.zz": 2.0}])
def test_what_such_motion_cannot_show_is_not_told(factors: dict[str, float], tmp_path: Path) -> None:
    verdict = verdict_of(tmp_path, factors)
    # an inertia of twice the size would not have shown, so that no all-clear is earned
    assert verdict["verdict"] == "cannot_judge" and not verdict["effects"]
    assert "inertia" in verdict["next_experiment"]["separates"]
