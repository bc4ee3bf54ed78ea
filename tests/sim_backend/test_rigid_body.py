"""The rigid body against software that we did not write: MuJoCo, and a Lagrangian derived by sympy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sim_backend.base_motion import body_rates, gravity_in_base
from sim_backend.model import AntennaModel, plant_arrays, shipped_model
from sim_backend.plant import joint_accelerations
from tests.sim_backend.mujoco_twin import mujoco_accelerations, mujoco_antenna

mujoco = pytest.importorskip("mujoco", reason="mujoco is not installed (the extra test has it)")


def accelerations(model: AntennaModel, state: dict[str, np.ndarray]) -> np.ndarray:
    """Our joint accelerations for a base given by Euler angles (yaw, pitch, roll) with rates and accelerations, and the
    acceleration of its pivot in axes of the world.
    """
    yaw, pitch, roll = state["euler"]
    dyaw, dpitch, droll = state["euler_rate"]
    # angular acceleration by the chain rule, done numerically with a complex step so that it shares nothing with the
    # plant's formula
    step = 1e-30

    def rates(angles: np.ndarray, speeds: np.ndarray) -> np.ndarray:
        _, p, r = angles
        dy, dp, dr = speeds
        cr, sr, cp, sp = np.cos(r), np.sin(r), np.cos(p), np.sin(p)
        return np.array([dr - dy * sp, dp * cr + dy * sr * cp, -dp * sr + dy * cr * cp])

    along = rates(
        state["euler"] + 1j * step * state["euler_rate"], state["euler_rate"] + 1j * step * state["euler_acceleration"]
    )
    arrays = plant_arrays(model)
    return joint_accelerations(
        arrays.P,
        arrays.K,
        state["q"],
        state["v"],
        state["torque"],
        np.array(gravity_in_base(model.file.gravity_m_s2, roll, pitch))
        - Rotation.from_euler("ZYX", [yaw, pitch, roll]).inv().apply(state["pivot_acceleration"]),
        np.array(body_rates(roll, pitch, droll, dpitch, dyaw)),
        along.imag / step,
    )


def random_state(rng: np.random.Generator, moving: bool, translating: bool = False) -> dict[str, np.ndarray]:
    base = 1.0 if moving else 0.0
    return {
        "euler": rng.uniform(-1.2, 1.2, 3),
        "euler_rate": base * rng.normal(0.0, 2.0, 3),
        "euler_acceleration": base * rng.normal(0.0, 5.0, 3),
        "pivot_acceleration": base * rng.normal(0.0, 8.0, 3) if translating else np.zeros(3),
        "q": rng.uniform(-3.0, 3.0, 2),
        "v": rng.normal(0.0, 3.0, 2),
        "torque": rng.normal(0.0, 5.0, 2),
    }


@pytest.mark.parametrize(("moving", "translating"), [(False, False), (True, False), (True, True)])
def test_accelerations_agree_with_mujoco(moving: bool, translating: bool) -> None:
    model = shipped_model()
    antenna = mujoco_antenna(model)
    rng = np.random.default_rng(7)
    worst = 0.0
    for _ in range(300):
        state = random_state(rng, moving, translating)
        theirs = mujoco_accelerations(
            antenna,
            state["euler"],
            state["euler_rate"],
            state["euler_acceleration"],
            state["pivot_acceleration"],
            state["q"],
            state["v"],
            state["torque"],
        )
        worst = max(worst, float(np.max(np.abs(accelerations(model, state) - theirs) / (1.0 + np.abs(theirs)))))
    assert worst < 1e-9


@pytest.mark.heavy
def test_accelerations_agree_with_a_symbolic_lagrangian() -> None:
    pytest.importorskip("sympy", reason="sympy is not installed (the extra test has it)")
    from tests.sim_backend.symbolic_lagrangian import lagrangian_accelerations

    model = shipped_model()
    theirs = lagrangian_accelerations(model)
    rng = np.random.default_rng(11)
    for _ in range(50):
        state = random_state(rng, moving=True)
        expected = theirs(state)
        np.testing.assert_allclose(
            accelerations(model, state), expected, rtol=0, atol=1e-9 * (1.0 + np.max(np.abs(expected)))
        )


def test_mass_matrix_has_the_values_that_the_errata_state() -> None:
    from sim_backend.rigid_body import equations_of_motion

    arrays = plant_arrays(shipped_model())
    level = ((0.0, 0.0, -9.81), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    mass, bias, *_ = equations_of_motion(arrays.P, arrays.K, (0.3, 0.0), (0.0, 0.0), level)
    np.testing.assert_allclose(mass, (0.5028, 2.815e-4, 0.06959), atol=1e-9)
    assert bias[0] == pytest.approx(0.0, abs=1e-12), "a level gimbal has no azimuth gravity torque"
    assert bias[1] == pytest.approx(5.08 * 9.81 * 0.02084, rel=1e-12)
    upright, *_ = equations_of_motion(arrays.P, arrays.K, (0.3, np.pi / 2), (0.0, 0.0), level)
    assert upright[0] == pytest.approx(0.4691, abs=5e-5)


def test_gravity_reading_total_mass_changes_the_outer_axis_alone() -> None:
    document = shipped_model().document | {"gravity_reading": "total_mass"}
    from sim_backend.model import model_from_document

    separate, total = plant_arrays(shipped_model()), plant_arrays(model_from_document(document, "test"))
    args = (np.array([0.4, 0.3]), np.zeros(2), np.zeros(2), np.array([1.0, 2.0, -9.0]), np.zeros(3), np.zeros(3))
    a = joint_accelerations(separate.P, separate.K, *args)
    b = joint_accelerations(total.P, total.K, *args)
    assert abs(a[0] - b[0]) > 0.1 and abs(a[1] - b[1]) < 0.02
