"""A joint that only moves on its bristles: their stiffness is told, and nothing else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.rigs.presliding import SIGMA0, write_presliding
from tests.rigs.told import Row, ask


def verdict_of(folder: Path, factors: dict[str, float], bristle: bool = True) -> dict[str, Any]:
    """What the command says of two logs and this model."""
    rig = write_presliding(folder, factors, bristle)
    found: dict[str, Any] = ask(Row("joint", rig, ("first",), ("second",), ""), folder / "out")["verdict"]
    return found


@pytest.mark.parametrize(
    ("factors", "bristle"),
    [
        ({"friction.sigma0": 0.5}, True),
        pytest.param({"friction.sigma0": 2.0}, True, marks=pytest.mark.heavy),
        # the model of a stranger, whose dry friction changes sign at once
        pytest.param({}, False, marks=pytest.mark.heavy),
    ],
)
def test_a_stiffness_that_is_wrong_or_missing_is_named_alone(
    factors: dict[str, float], bristle: bool, tmp_path: Path
) -> None:
    verdict = verdict_of(tmp_path, factors, bristle)
    assert [one["name"] for one in verdict["effects"]] == ["presliding"]
    assert verdict["verdict"] == "named"
    assert verdict["effects"][0]["parameters"]["sigma0"]["value"] == pytest.approx(SIGMA0, rel=0.04)
    # what such a joint does within its bristles is no torque column of another time
    assert not verdict["contradictions"], verdict["contradictions"]


@pytest.mark.heavy
@pytest.mark.parametrize("factors", [{}, {"body.inertia.zz": 2.0}])
def test_what_such_motion_cannot_show_is_not_told(factors: dict[str, float], tmp_path: Path) -> None:
    verdict = verdict_of(tmp_path, factors)
    # an inertia of twice the size would not have shown, so that no all-clear is earned
    assert verdict["verdict"] == "cannot_judge" and not verdict["effects"]
    assert "inertia" in verdict["next_experiment"]["separates"]
