"""Two measured rigs, step by step; run with `-s` to see the figures. Skipped where the data are not there."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gimbal_hil.discrepancy import corrected_model, diagnose, recalibrated_model, verdict_of
from gimbal_hil.discrepancy.hypothesis import known_offsets
from tests.discrepancy.measured_rigs import (
    ARM_FITTED,
    ARM_JUDGED,
    arm_logs,
    arm_model,
    emps_laps,
    emps_logs,
    emps_model,
    left_over,
    with_free,
)

pytestmark = pytest.mark.heavy


def steps(diagnosis: Any) -> list[tuple[str, float]]:
    """Every cause in the order in which it was added, with what was left on the selecting half of the hold-out, in N or
    N m.
    """
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


def test_emps_each_lap_is_judged_by_what_the_others_say() -> None:
    """Names from two laps, judged by a third; refitted to the three; what is left of the fourth, in a band that ends at
    20 Hz.
    """
    laps, model = emps_laps(), emps_model(20.3935)
    before, after = [], []
    for left_out in range(4):
        others = [lap for k, lap in enumerate(laps) if k != left_out]
        diagnosis = diagnose(model, tuple(others[:2]), (others[2],), band_hz=20.0)
        floor = float(diagnosis.search.floor[0])
        for kept, state in ((before, diagnosis.null), (after, diagnosis.best)):
            kept.append(left_over(model, state.hypothesis, others, [laps[left_out]], 20.0, floor))
        print(
            f"lap {left_out + 1}: {before[-1]:.2f} to {after[-1]:.2f} N, floor {floor:.2f} N",
            diagnosis.best.hypothesis.labels,
        )
    first, last = (float(np.sqrt(np.mean(np.square(rms)))) for rms in (before, after))
    print(f"all laps: {first:.2f} to {last:.2f} N")
    assert 0.30 < last < 1.2


def test_emps_pulses_follow_from_the_first_file_but_for_the_phase_of_the_screw() -> None:
    """Names and numbers from the first file; the ripple's phase and the drive's offset, which are each run's own, from
    half of PULSES.
    """
    laps = emps_logs("DATA_EMPS")
    diagnosis = diagnose(emps_model(20.3935), laps[:1], laps[1:])
    model, fitted_judged = recalibrated_model(diagnosis), emps_logs("DATA_EMPS_PULSES")
    held = replace(with_free(diagnosis.best.hypothesis, "phase"), floating=known_offsets(model), y=(0.0,))
    halves = (fitted_judged, fitted_judged[::-1])
    before, after = (
        [left_over(model, which, [here], [there], 100.0, 1.0) for here, there in halves]
        for which in (replace(held, causes=()), held)
    )
    print(
        f"PULSES, 100 Hz: {before[0]:.2f} and {before[1]:.2f} to {after[0]:.2f} and {after[1]:.2f} N",
        diagnosis.best.hypothesis.labels,
    )
    assert float(np.sqrt(np.mean(np.square(after)))) < 2.2


def test_the_arm_gains_a_direction_first() -> None:
    diagnosis = diagnose(arm_model(), arm_logs(ARM_FITTED), arm_logs(ARM_JUDGED))
    verdict = verdict_of(diagnosis)
    print(steps(diagnosis), verdict["text"])
    assert diagnosis.best.hypothesis.labels[0][0] == "coulomb_asymmetry"
    asymmetry = next(e for e in verdict["effects"] if e["name"] == "coulomb_asymmetry")["parameters"]["asymmetry"]
    assert asymmetry["low"] < (12.4401 - 10.9366) / (12.4401 + 10.9366) < asymmetry["high"]
