"""Measured rigs of other people, with a stranger's first model: what is named stands, and nothing else is.

Skipped where the data are not there.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from gimbal_hil.cli import main
from tests.rigs import write_bam, write_odrive

pytestmark = pytest.mark.heavy


def verdict_on(
    model: Path, measured: list[Path], holdout: Path, out: Path, monkeypatch: pytest.MonkeyPatch
) -> dict[str, Any]:
    """What the command says."""
    words = [
        "gimbal-hil",
        "discrepancy",
        "--model",
        str(model),
        "--holdout",
        str(holdout),
        "--out",
        str(out),
        "--resample",
    ]
    for log in measured:
        words += ["--measured", str(log)]
    monkeypatch.setattr("sys.argv", words)
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code in (0, None)
    found: dict[str, Any] = json.loads((out / "verdict.json").read_text())
    return found


def test_a_slow_motor_has_its_ripple_of_seven_a_turn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rig = write_odrive(tmp_path)
    verdict = verdict_on(
        rig.model, [rig.logs["slow2/nocomp_0"]], rig.logs["slow2/nocomp_1"], tmp_path / "out", monkeypatch
    )
    told = {e["name"]: e for e in verdict["effects"]}
    assert told["cogging"]["status"] == "named"
    # what deletes the torque, and what stands at its bounds, closed this gap "by 100 %" once
    assert not set(told) & {"saturation", "torque_gain", "backlash", "inertia"}
    found = told["cogging"]["parameters"]
    assert found["order"]["value"] == pytest.approx(7.0, abs=0.05)
    assert 6.5e-3 < found["amplitude"]["value"] < 9e-3


def test_a_pendulum_hangs_out_of_balance_or_in_a_class_that_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = write_bam(tmp_path)
    fitted = [rig.logs["kp400_sin_sin"], rig.logs["kp400_sin_time_square"]]
    verdict = verdict_on(rig.model, fitted, rig.logs["kp400_up_and_down"], tmp_path / "out", monkeypatch)
    told = {entry["name"] for entry in (*verdict["effects"], *verdict["alternatives"])}
    assert "static_unbalance" in told
    assert verdict["verdict"] == "named" or verdict["next_experiment"]
