"""Other designs keep what `tune` keeps, and are what their books say."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from gimbal_hil.knowledge.tuning import (
    MARGIN,
    AxisDynamics,
    SampledLaw,
    TuningTask,
    as_array,
    disk_margin,
    figures,
    largest_pole,
    loop_shaped,
    notched,
    regulated,
    tuning_task,
)
from gimbal_hil.knowledge.tuning.choosing import cascade_laws
from gimbal_hil.knowledge.tuning.rivals import regulator, robust_stabiliser
from sim_backend.model import shipped_model


@pytest.fixture(scope="module")
def task() -> TuningTask:
    return tuning_task(shipped_model("realistic"), "inner", 1e-3, MARGIN)


@pytest.mark.heavy
@pytest.mark.parametrize(
    "design", [notched, loop_shaped, lambda task: regulated(shipped_model("realistic"), "inner", task)]
)
def test_a_design_keeps_the_margin_on_every_case_and_survives_wrong_plants(design, task: TuningTask) -> None:  # type: ignore[no-untyped-def]
    found = design(task)
    assert found is not None
    said = figures(found.laws, task)
    assert said.margin >= MARGIN and said.stable_when_wrong and said.error_rad < 3e-4


def test_a_notch_at_every_mode_takes_the_gain_out_there_and_nowhere_below(task: TuningTask) -> None:
    numbers = (20.0, 60.0, 10.0)
    plain = cascade_laws(numbers, task)[0]
    with_notch = _made(notched, task, numbers)
    mode, _, share = task.cases[0].modes[0]
    w = np.array([5.0, mode / math.sqrt(1.0 - share)])
    (_, gyro), (_, without) = with_notch.answers(w), plain.answers(w)
    ratio = np.abs(gyro / without)
    assert ratio[0] == pytest.approx(1.0, abs=0.02) and ratio[1] == pytest.approx(0.1, abs=0.02)


def _made(design, task: TuningTask, numbers: tuple[float, float, float]) -> SampledLaw:  # type: ignore[no-untyped-def]
    """What a design makes of numbers, without a search."""
    from gimbal_hil.knowledge.tuning import rivals

    found = []
    original = rivals.search
    rivals.search = lambda grid, make, task: found.append(make(numbers)[0])  # type: ignore[assignment]
    try:
        design(task)
    finally:
        rivals.search = original
    law = found[0]
    assert isinstance(law, SampledLaw)
    return replace(law, answered=None)


def test_the_poles_of_a_sampled_law_are_those_of_the_same_cascade(task: TuningTask) -> None:
    numbers, bare = (20.0, 60.0, 10.0), replace(task, cases=(replace(task.cases[0], modes=()),))
    law = _made(notched, bare, numbers)
    for case in task.cases:
        assert largest_pole(law, case) == pytest.approx(largest_pole(cascade_laws(numbers, task)[0], case), abs=1e-9)
    w = np.geomspace(0.1, 1000.0, 50)
    np.testing.assert_allclose(
        law.torque(w, task.cases[0]), cascade_laws(numbers, task)[0].torque(w, task.cases[0]), rtol=1e-9
    )


def test_robust_stabilisation_of_an_integrator_has_the_margin_of_theory() -> None:
    # 1 / s: the largest radius is 1 / sqrt(2) (Vidyasagar and Kimura), its controller the gain 1
    A, B, C, D = robust_stabiliser((np.zeros((1, 1)), np.eye(1), np.eye(1), np.zeros((1, 1))))
    gain = float((D - C @ np.linalg.solve(A, B))[0, 0])
    assert gain == pytest.approx(1.0, rel=0.3)
    closed = np.block([[np.zeros((1, 1)), C], [-B, A]])
    assert np.linalg.eigvals(closed).real.max() < 0.0


def test_the_regulator_of_a_fast_double_integrator_is_damped_by_a_root_of_a_half() -> None:
    # continuous: gains w^2 and sqrt(2) w on position and rate
    found = regulator(50.0, 1e-5)
    assert found.crossing == pytest.approx(math.sqrt(2.0) * 50.0, rel=1e-3)
    assert found.position_kp == pytest.approx(50.0 / math.sqrt(2.0), rel=1e-3)


def test_laws_of_two_axes_are_filled_up_to_one_size() -> None:
    small = SampledLaw(1e-3, np.array([[0.5]]), np.array([[1.0, 2.0]]), np.array([[3.0]]), np.array([[4.0, 5.0]]))
    large = SampledLaw(1e-3, np.eye(2), np.ones((2, 2)), np.ones((1, 2)), np.zeros((1, 2)))
    found = as_array([small, large])
    assert found.shape == (2, 3, 4)
    np.testing.assert_array_equal(found[0], [[0.5, 0.0, 1.0, 2.0], [0.0] * 4, [3.0, 0.0, 4.0, 5.0]])


def test_an_axis_without_modes_gets_no_notch() -> None:
    case = AxisDynamics(0.5, 0.05, 0.0, 0.002, 0.0, 0.0)
    bare = TuningTask(
        1e-3, (case,), tuning_task(shipped_model("realistic"), "inner", 1e-3, MARGIN).disturbances, MARGIN
    )
    law = _made(notched, bare, (20.0, 60.0, 10.0))
    assert len(law.A) == 2 and disk_margin(law.torque(np.geomspace(1.0, 3000.0, 200), case)) > 0.4
