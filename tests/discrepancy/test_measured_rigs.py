"""Two measured rigs, step by step; run with `-s` to see the figures. Skipped where the data are not there."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gimbal_hil.discrepancy import corrected_model, diagnose, verdict_of
from tests.discrepancy.measured_rigs import ARM_FITTED, ARM_JUDGED, arm_logs, arm_model, emps_logs, emps_model

pytestmark = pytest.mark.heavy


def steps(diagnosis: Any) -> list[tuple[str, float]]:
    """Every cause in the order in which it was added, with what was left on the selecting half of the hold-out, in N or N m."""
    floor = float(diagnosis.search.floor[0])
    found = [("", float(np.sqrt(np.mean(diagnosis.null.holdout[:, 0] ** 2))) * floor)]
    for one, label in zip(diagnosis.rounds, diagnosis.best.hypothesis.labels, strict=False):
        state = next(s for s in one.tried if s.hypothesis.labels[-1] == label)
        found.append((label[0], float(np.sqrt(np.mean(state.holdout[:, 0] ** 2))) * floor))
    return found


def test_emps_without_coulomb_friction_names_it_first() -> None:
    fitted, judged = emps_logs("DATA_EMPS")
    diagnosis = diagnose(emps_model(0.0), (fitted,), (judged,))
    verdict = verdict_of(diagnosis)
    print(steps(diagnosis), verdict["text"])
    assert diagnosis.best.hypothesis.labels[0][0] == "coulomb"
    assert verdict["effects"][0]["parameters"]["coulomb"]["value"] == pytest.approx(20.39, rel=0.03)


def test_emps_published_model_gains_direction_then_a_dip_then_the_screw_then_timing() -> None:
    fitted, judged = emps_logs("DATA_EMPS")
    diagnosis = diagnose(emps_model(20.3935), (fitted,), (judged,))
    verdict = verdict_of(diagnosis)
    print(steps(diagnosis), verdict["text"])
    names = [name for name, _ in diagnosis.best.hypothesis.labels]
    assert "contradict" in verdict["text"]
    assert names[:3] == ["viscous_asymmetry", "stribeck", "cogging"]
    drag = next(e for e in verdict["effects"] if e["name"] == "viscous_asymmetry")
    assert drag["form_undetermined"]["canonical_correlation"] > 0.95
    screw = next(e for e in verdict["effects"] if e["name"] == "cogging")
    assert 2.0 * np.pi / screw["parameters"]["order"]["value"] == pytest.approx(2.5e-3, rel=0.005)
    assert verdict["gap"]["after"] < 1.2 and verdict["gap"]["after"] > 0.30
    assert corrected_model(diagnosis) is not None


def test_emps_pulses_are_not_taken_for_a_resonance() -> None:
    fitted, judged = emps_logs("DATA_EMPS_PULSES")
    verdict = verdict_of(diagnose(emps_model(20.3935), (fitted,), (judged,)))
    print(verdict["text"])
    assert not {"structural_resonance", "transport_delay"} & {e["name"] for e in verdict["effects"]}
    assert verdict["gap"]["after"] < 2.2


def test_the_arm_gains_a_direction_first() -> None:
    diagnosis = diagnose(arm_model(), arm_logs(ARM_FITTED), arm_logs(ARM_JUDGED))
    verdict = verdict_of(diagnosis)
    print(steps(diagnosis), verdict["text"])
    assert diagnosis.best.hypothesis.labels[0][0] == "coulomb_asymmetry"
    asymmetry = next(e for e in verdict["effects"] if e["name"] == "coulomb_asymmetry")["parameters"]["asymmetry"]
    assert asymmetry["low"] < (12.4401 - 10.9366) / (12.4401 + 10.9366) < asymmetry["high"]
