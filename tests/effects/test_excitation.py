"""The run that the catalogue names for an effect shows it, and a run that lacks what it names does not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from sim_backend.effects import CATALOGUE
from sim_backend.model import AntennaModel
from tests.effects.rigs import RATE_HZ, antenna, columns, run

#: what the shipped sensors resolve: rad and rad/s
FLOOR = {"encoder": 1.5e-6, "gyro": 2e-4}
N = 4000
T = np.arange(N) / RATE_HZ
MOVING = {
    "motion": "sinusoid",
    "amplitude_rad": {"roll": 0.2, "pitch": 0.2, "yaw": 0.3},
    "frequency_hz": {"roll": 0.5, "pitch": 0.7, "yaw": 0.3},
}


def chirp() -> np.ndarray:
    return 3.0 * np.sin(2.0 * np.pi * (0.5 + 4.0 * T) * T)


def reversals() -> np.ndarray:
    return 0.8 * np.sign(np.sin(2.0 * np.pi * 1.0 * T))


def slow_both_ways() -> np.ndarray:
    return 0.3 * np.sin(2.0 * np.pi * 0.4 * T)


def below_break_away() -> np.ndarray:
    return 0.1 * np.sin(2.0 * np.pi * 1.0 * T)


def nothing() -> np.ndarray:
    return np.zeros(N)


@dataclass(frozen=True)
class Case:
    """An effect of a usual size, a run that should show it and one that should not; on the outer axis."""

    parameters: dict[str, float]
    shows: Callable[[], np.ndarray]
    hides: Callable[[], np.ndarray] = nothing
    shows_base: dict | None = None
    signal: str = "encoder"
    #: set on the model in both runs
    numbers: dict[str, float] | None = None


CASES: dict[str, Case] = {
    "viscous": Case({"viscous": 0.12}, chirp),
    "coulomb": Case({"coulomb": 0.26, "breakaway": 0.28}, reversals),
    "stribeck": Case({"breakaway": 0.3, "stribeck_velocity": 0.02}, slow_both_ways),
    "presliding": Case({"sigma0": 150.0}, below_break_away),
    "coulomb_asymmetry": Case({"asymmetry": 0.1}, reversals),
    "viscous_asymmetry": Case({"asymmetry": 0.3}, chirp),
    "load_dependent_friction": Case({"coefficient": 0.05}, reversals),
    "position_dependent_friction": Case({"relative_amplitude": 0.2, "order": 7.0}, reversals),
    "quadratic_drag": Case({"coefficient": 0.05}, reversals),
    "temperature_viscosity": Case({"temperature_coefficient": 0.02}, chirp, numbers={"thermal.ambient": 60.0}),
    "static_unbalance": Case({"cog_x": 0.07}, nothing, shows_base=MOVING),
    "dynamic_unbalance": Case({"ixz": 0.03, "iyz": 0.02}, reversals, shows_base=MOVING),
    "inertia": Case({"inertia": 0.46}, chirp),
    "torque_gain": Case({"gain_error": 0.05}, reversals),
    "torque_offset": Case({"offset": 0.05}, reversals, hides=lambda: np.full(0, 0.0)),
    "saturation": Case({"limit": 2.0}, chirp, hides=reversals),
    "actuator_lag": Case({"time_constant": 0.003}, chirp),
    "gyro_bias": Case({"bias": 0.005}, nothing, hides=lambda: np.full(0, 0.0), signal="gyro"),
    "gyro_scale": Case({"scale_error": 0.02}, reversals, signal="gyro"),
    "gyro_misalignment": Case({"leak_x": 0.03, "leak_y": 0.02}, nothing, shows_base=MOVING, signal="gyro"),
    "cogging": Case({"amplitude": 0.03, "order": 12.0, "phase": 0.3}, reversals, hides=lambda: np.full(0, 0.0)),
    "cable_spring": Case({"stiffness": 0.2}, reversals),
    "back_emf": Case({"coefficient": 0.1}, chirp),
    "transport_delay": Case({"delay": 0.003}, chirp),
    "structural_resonance": Case({"antiresonance_frequency": 12.0, "damping_ratio": 0.02, "inertia_share": 0.2}, chirp),
    "backlash": Case({"gap": 2e-3, "rotor_inertia": 0.1}, reversals),
    "encoder_eccentricity": Case({"amplitude": 1e-3}, reversals),
}


def difference(case: Case, name: str, torque: np.ndarray, base: dict | None) -> float:
    """Rms change of the case's signal of the outer axis in units of its floor."""
    model: AntennaModel = antenna(**(base or {}))
    # the inner gimbal would fall under its own weight and shake the outer one
    model = model.with_numbers("inner", {f"body.cog.{key}": 0.0 for key in "xyz"})
    for path, value in (case.numbers or {}).items():
        model = model.with_number("outer", path, value)
    both = np.column_stack([torque, np.zeros(len(torque))])
    without, with_it = columns(run(model, both)), columns(run(model.with_effect(name, "outer", case.parameters), both))
    return float(np.sqrt(np.mean((with_it[case.signal][:, 0] - without[case.signal][:, 0]) ** 2)) / FLOOR[case.signal])


def test_every_effect_has_a_case() -> None:
    assert set(CASES) >= set(CATALOGUE)


@pytest.mark.parametrize("name", CASES)
def test_the_run_that_excites_an_effect_shows_it_far_above_the_sensor_floor(name: str) -> None:
    case = CASES[name]
    assert difference(case, name, case.shows(), case.shows_base) > 10.0


@pytest.mark.parametrize("name", [name for name, case in CASES.items() if len(case.hides())])
def test_a_run_without_what_excites_an_effect_does_not_show_it(name: str) -> None:
    case = CASES[name]
    assert difference(case, name, case.hides(), None) < 0.5
