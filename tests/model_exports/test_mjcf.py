"""A model written as MJCF moves in MuJoCo, by MuJoCo's own laws, as it moves here."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from gimbal_hil.knowledge.model_exports import ModelFormat, export_model, has_dcmotor
from sim_backend.model import AntennaModel, load_model, shipped_model, shipped_model_path
from sim_backend.plant import Plant

RESONANCE = {"antiresonance_frequency": 15.0, "damping_ratio": 0.03, "inertia_share": 0.25}
RATE_HZ, SUBSTEPS, TICKS = 1000.0, 10, 1500
pytestmark = pytest.mark.skipif(not has_dcmotor(), reason="this MuJoCo has no passive dcmotor")


def antenna() -> AntennaModel:
    """The shipped antenna, balanced, with a Stribeck bump as MuJoCo's."""
    model = shipped_model()
    for axis in model.axes:
        model = model.with_numbers(axis, {"friction.shape": 2.0, **{f"body.cog.{k}": 0.0 for k in "xyz"}})
    return model


def torque() -> np.ndarray:
    t = np.arange(TICKS) / RATE_HZ
    return np.stack([2.0 * np.sin(2 * np.pi * (t + 4 * t * t)), 0.8 * np.sin(2 * np.pi * (2 * t + 4 * t * t))], axis=1)


def moved_in_mujoco(model: AntennaModel, commanded: np.ndarray) -> np.ndarray:
    """Joint positions, one row a tick."""
    built = mujoco.MjModel.from_xml_string(export_model(model, ModelFormat.MJCF).text)
    data = mujoco.MjData(built)
    places = [built.joint(axis).qposadr[0] for axis in model.axes]
    rows = []
    for command in commanded:
        rows.append(data.qpos[places].copy())
        data.ctrl[:] = command
        for _ in range(SUBSTEPS):
            mujoco.mj_step(built, data)
    return np.array(rows)


@pytest.mark.parametrize(
    ("axis", "name", "parameters"),
    [
        ("outer", "cogging", {"amplitude": 0.3, "order": 7.0, "phase": 0.4}),
        ("inner", "cable_spring", {"stiffness": 2.0, "rest_position": 0.2}),
        ("outer", "quadratic_drag", {"coefficient": 2.0}),
        ("inner", "back_emf", {"coefficient": 0.3}),
        ("outer", "transport_delay", {"delay": 0.004}),
        ("outer", "actuator_lag", {"time_constant": 0.01}),
        ("inner", "torque_gain", {"gain_error": 0.1}),
        ("inner", "torque_offset", {"offset": 0.2}),
        ("outer", "saturation", {"limit": 1.0}),
        (
            "outer",
            "structural_resonance",
            {"antiresonance_frequency": 15.0, "damping_ratio": 0.03, "inertia_share": 0.25},
        ),
        (
            "inner",
            "structural_resonance",
            {"antiresonance_frequency": 15.0, "damping_ratio": 0.03, "inertia_share": 0.25},
        ),
        ("inner", "viscous", {"viscous": 0.2}),
        ("outer", "coulomb", {"coulomb": 0.4, "breakaway": 0.45}),
        ("inner", "presliding", {"sigma0": 60.0, "sigma1": 2.0}),
    ],
)
def test_an_effect_moves_the_antenna_in_mujoco_as_here(axis: str, name: str, parameters: dict[str, float]) -> None:
    with_it = antenna().with_effect(name, axis, parameters)
    here, there = Plant(with_it).run(torque()).position, moved_in_mujoco(with_it, torque())
    moved = np.abs(here - Plant(antenna()).run(torque()).position).max()
    # the two integrate by different rules: what is left between them is small against what the effect does
    assert np.abs(here - there).max() < 0.06 * moved
    account = export_model(with_it, ModelFormat.MJCF)
    assert not {told.item.name for told in account.left_out} & {name}


@pytest.mark.parametrize("shipped", ["emps", "realistic", "thesis"])
def test_shipped_models_load_in_mujoco_with_a_control_for_each_axis(shipped: str) -> None:
    model = load_model(shipped_model_path().with_name(f"{shipped}.yaml"))
    built = mujoco.MjModel.from_xml_string(export_model(model, ModelFormat.MJCF).text)
    assert built.nu == len(model.axes)


def test_an_unbalanced_axis_that_leans_falls_as_here() -> None:
    model = shipped_model()
    here, there = Plant(model).run(0.0 * torque()).position, moved_in_mujoco(model, 0.0 * torque())
    assert np.abs(here).max() > 0.3
    assert np.abs(here - there).max() < 1e-3 * np.abs(here).max()
