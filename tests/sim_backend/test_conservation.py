"""What physics keeps, the plant keeps: energy, momentum, and the order of its integrator."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim_backend import layout
from sim_backend.model import AntennaModel, model_from_document, shipped_model
from sim_backend.plant import Plant, run_steps

FRICTIONLESS = dict.fromkeys(("breakaway", "coulomb", "sigma0", "sigma1", "viscous"), 0.0) | {
    "stribeck_velocity": 0.01,
    "shape": 1.0,
}


def variant(
    friction: bool, gravity: float = 9.81, step_s: float = 1e-4, effects: tuple[dict[str, object], ...] = ()
) -> AntennaModel:
    """The shipped antenna with friction or without, another gravity or plant step."""
    document = copy.deepcopy(shipped_model().document)
    document |= {"gravity_m_s2": gravity, "plant_step_s": step_s, "effects": list(effects)}
    if not friction:
        for axis in document["axes"].values():
            axis["friction"] = FRICTIONLESS
    return model_from_document(document, "variant")


def started(model: AntennaModel, q: tuple[float, float], v: tuple[float, float], rate_hz: float = 1000.0) -> Plant:
    plant = Plant(model, rate_hz)
    plant.X[layout.POSITION : layout.POSITION + 2] = q
    plant.X[layout.RATE : layout.RATE + 2] = v
    return plant


def energy(plant: Plant) -> float:
    """Kinetic and potential energy on a fixed level base, J, written down independently of the plant."""
    eps = plant.X[layout.POSITION + 1]
    deta, deps = plant.X[layout.RATE : layout.RATE + 2]
    total = 0.0
    c, s = np.cos(eps), np.sin(eps)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    for axis, rate, to_outer in (
        ("outer", np.array([0, 0, deta]), np.eye(3)),
        ("inner", turn.T @ np.array([0, 0, deta]) + np.array([0, deps, 0]), turn),
    ):
        n = {k: plant.model.number(axis, f"body.inertia.{k}") for k in ("xx", "yy", "zz", "xy", "xz", "yz")}
        tensor = np.array([[n["xx"], n["xy"], n["xz"]], [n["xy"], n["yy"], n["yz"]], [n["xz"], n["yz"], n["zz"]]])
        cog = np.array([plant.model.number(axis, f"body.cog.{k}") for k in "xyz"])
        total += (
            0.5 * rate @ tensor @ rate
            + plant.model.number(axis, "body.mass") * plant.model.file.gravity_m_s2 * (to_outer @ cog)[2]
        )
    return float(total)


def azimuth_momentum(plant: Plant) -> float:
    """Angular momentum about the azimuth axis on a fixed base, N m s."""
    from sim_backend.rigid_body import equations_of_motion

    level = ((0.0, 0.0, -plant.model.file.gravity_m_s2), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    q, v = plant.X[layout.POSITION : layout.POSITION + 2], plant.X[layout.RATE : layout.RATE + 2]
    mass, *_ = equations_of_motion(plant.P, plant.K, (q[0], q[1]), (v[0], v[1]), level)
    return float(mass[0] * v[0] + mass[1] * v[1])


states = st.tuples(st.floats(-3, 3), st.floats(-3, 3)), st.tuples(st.floats(-5, 5), st.floats(-5, 5))


@settings(max_examples=25)
@given(q=states[0], v=states[1])
def test_without_friction_energy_stays(q: tuple[float, float], v: tuple[float, float]) -> None:
    plant = started(variant(friction=False), q, v)
    before = energy(plant)
    run_steps(plant.P, plant.K, plant.X, 0.0, 0.0, 20_000)
    assert energy(plant) == pytest.approx(before, rel=2e-5, abs=2e-5)


@settings(max_examples=25)
@given(q=states[0], v=states[1])
def test_without_gravity_azimuth_momentum_stays_whatever_the_inner_motor_does(
    q: tuple[float, float], v: tuple[float, float]
) -> None:
    plant = started(variant(friction=False, gravity=0.0), q, v)
    before = azimuth_momentum(plant)
    run_steps(plant.P, plant.K, plant.X, 0.0, 0.3, 10_000)
    assert azimuth_momentum(plant) == pytest.approx(before, rel=1e-5, abs=1e-5)


@settings(max_examples=25)
@given(q=states[0], v=states[1])
def test_with_friction_energy_never_grows(q: tuple[float, float], v: tuple[float, float]) -> None:
    plant = started(variant(friction=True), q, v)
    last = energy(plant)
    for _ in range(40):
        run_steps(plant.P, plant.K, plant.X, 0.0, 0.0, 500)
        now = energy(plant)
        # what the bristles store may come back: at most Ts^2 / (2 sigma0) on each axis
        assert now <= last + 2 * 0.2585**2 / (2 * 238.88)
        last = now


def test_a_long_run_gains_no_energy() -> None:
    plant = started(variant(friction=False), (0.4, 0.3), (1.0, -2.0))
    before = energy(plant)
    drift = []
    for _ in range(20):
        run_steps(plant.P, plant.K, plant.X, 0.0, 0.0, 100_000)
        drift.append(energy(plant) - before)
    assert max(abs(np.array(drift))) < 1e-4 * abs(before)
    assert abs(np.mean(drift[10:]) - np.mean(drift[:10])) < 2e-5 * abs(before)


def convergence(steps_s: list[float]) -> list[float]:
    """Position error (rad) after one second of smooth torques against a step eight times finer than the last, for each
    step.
    """

    def end(step_s: float) -> np.ndarray:
        plant = Plant(variant(friction=True, step_s=step_s), rate_hz=1.0 / step_s)
        t = step_s * (np.arange(round(1.0 / step_s)) + 0.5)
        plant.run(np.column_stack([2.0 * np.sin(2 * np.pi * t), 1.04 + 0.8 * np.sin(2 * np.pi * 1.5 * t)]))
        return plant.position

    reference = end(steps_s[-1] / 8)
    return [float(np.max(np.abs(end(step) - reference))) for step in steps_s]


def test_the_whole_plant_converges_at_second_order() -> None:
    errors = convergence([4e-4, 2e-4, 1e-4, 5e-5])
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.all(orders > 1.6), (errors, orders)
    assert errors[2] < 1e-5, "at the shipped step of 0.1 ms"
