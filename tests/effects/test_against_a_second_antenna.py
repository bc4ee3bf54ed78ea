"""Every effect against the bench's own antenna, which shares no code with the plant: its torques, replayed here, give
its motion.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sim_backend.model import AntennaModel
from sim_backend.plant import Plant
from tests.blind.antenna import COLUMNS, IX, STILL, simulate
from tests.blind.causes import BODY, THESIS
from tests.blind.rigid import base_state
from tests.effects.rigs import antenna

N, STEP_S, WARM_DEGC = 3000, 1e-3, 40.0
TILT = np.array([[0.05, 0.0, 0.0, 0.0], [-0.08, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]])
SWAY = np.array([[0.05, 0.2, 0.5, 0.3], [-0.08, 0.15, 0.7, 1.0], [0.0, 0.3, 0.4, 2.0]])
#: name -> (columns of the second antenna, body entries there, parameters here, moving base)
Case = tuple[dict[str, float], dict[int, float], dict[str, float], bool]
CASES: dict[str, Case] = {
    "viscous": ({"s2": 0.15}, {}, {"viscous": 0.15}, False),
    "coulomb": ({"Tc": 0.26, "Ts": 0.28}, {}, {"coulomb": 0.26, "breakaway": 0.28}, False),
    "stribeck": ({"Ts": 0.31, "vs": 0.02}, {}, {"breakaway": 0.31, "stribeck_velocity": 0.02}, False),
    "presliding": ({"s0": 160.0, "s1": 13.0}, {}, {"sigma0": 160.0, "sigma1": 13.0}, False),
    "coulomb_asymmetry": ({"asym_c": 0.1}, {}, {"asymmetry": 0.1}, False),
    "viscous_asymmetry": ({"asym_v": -0.3}, {}, {"asymmetry": -0.3}, False),
    "load_dependent_friction": ({"load_c": 0.05}, {}, {"coefficient": 0.05}, False),
    "position_dependent_friction": (
        {"pos_a": 0.1, "pos_n": 5.0, "pos_ph": 0.7},
        {},
        {"relative_amplitude": 0.1, "order": 5.0, "phase": 0.7},
        False,
    ),
    "quadratic_drag": ({"quad": 0.05}, {}, {"coefficient": 0.05}, False),
    "temperature_viscosity": ({"temp_b": 0.02}, {}, {"temperature_coefficient": 0.02}, False),
    "static_unbalance": ({}, {6: 0.07, 7: -0.01, 8: -0.01767}, {"cog_x": 0.07, "cog_y": -0.01}, True),
    "dynamic_unbalance": ({}, {3: 0.05, 4: 0.03, 5: 0.02}, {"ixy": 0.05, "ixz": 0.03, "iyz": 0.02}, True),
    "inertia": ({}, {2: 0.46}, {"inertia": 0.46}, False),
    "torque_gain": ({"gain": -0.05}, {}, {"gain_error": -0.05}, False),
    "torque_offset": ({"offset": 0.05}, {}, {"offset": 0.05}, False),
    "saturation": ({"limit": 1.0}, {}, {"limit": 1.0}, False),
    "actuator_lag": ({"lag": 2e-3}, {}, {"time_constant": 2e-3}, False),
    "gyro_bias": ({"g_bias": 0.005}, {}, {"bias": 0.005}, False),
    "gyro_scale": ({"g_scale": 0.01}, {}, {"scale_error": 0.01}, False),
    "gyro_misalignment": ({"leak_x": 0.03, "leak_y": 0.02}, {}, {"leak_x": 0.03, "leak_y": 0.02}, True),
    "cogging": (
        {"cog_a": 0.02, "cog_n": 12.0, "cog_ph": -1.0},
        {},
        {"amplitude": 0.02, "order": 12.0, "phase": -1.0},
        False,
    ),
    "cable_spring": ({"spring_k": 0.05, "spring_q0": 0.3}, {}, {"stiffness": 0.05, "rest_position": 0.3}, False),
    "back_emf": ({"emf": 0.1}, {}, {"coefficient": 0.1}, False),
    "transport_delay": ({"delay": 2.3e-3}, {}, {"delay": 2.3e-3}, False),
    "structural_resonance": (
        {"res_w": 2.0 * math.pi * 15.0, "res_z": 0.03, "res_share": 0.1},
        {},
        {"antiresonance_frequency": 15.0, "damping_ratio": 0.03, "inertia_share": 0.1},
        True,
    ),
    "encoder_eccentricity": ({"ecc_a": 1e-3, "ecc_ph": 0.4}, {}, {"amplitude": 1e-3, "phase": 0.4}, False),
}


def second_antenna(row: dict[str, float], body: dict[int, float], base: np.ndarray) -> np.ndarray:
    """The second antenna's closed loop without noise: columns 0-1 torque, 2-3 encoder, 4-5 gyro."""
    nominal = np.zeros((2, len(COLUMNS)))
    nominal[:, IX["limit"]] = 15.5, 6.6
    for a, axis in enumerate(("outer", "inner")):
        for key, value in THESIS[axis].items():
            nominal[a, IX[key]] = value
    true, outer = nominal.copy(), BODY["outer"].copy()
    for key, value in row.items():
        true[0, IX[key]] = value
    for index, value in body.items():
        outer[index] = value
    t = STEP_S * np.arange(N)
    reference = np.zeros((N, 2, 3))
    for a, (amplitude, frequency) in enumerate(((0.5, 0.6), (0.3, 0.9))):
        reference[:, a, 0] = amplitude * np.clip(t, 0.0, 1.0) ** 2 * np.sin(2.0 * np.pi * frequency * t)
        reference[:, a, 1] = np.gradient(reference[:, a, 0], STEP_S)
        reference[:, a, 2] = np.gradient(reference[:, a, 1], STEP_S)
    gains = np.array([[8.0, 35.0, 200.0, 0.3, 15.5], [10.0, 5.0, 35.0, 0.05, 6.6]])
    heat, ideal, calm = np.full((N, 2), WARM_DEGC), np.zeros((2, 3)), np.tile(STILL, (N, 2, 1))
    args = (BODY["outer"], BODY["inner"], base, reference, heat, calm, gains, ideal, 1, STEP_S, False)
    return np.asarray(simulate(0, true, nominal, outer, BODY["inner"], *args))


def here(base: np.ndarray, folder: Path) -> AntennaModel:
    """The shipped antenna on the second antenna's base, as warm as it."""
    if base is TILT:
        section: dict[str, Any] = {"motion": "fixed", "attitude_rad": {"roll": 0.05, "pitch": -0.08}}
    else:
        rows = [(k * STEP_S, *base_state(base, k * STEP_S)[0]) for k in range(-2, N + 10)]
        text = "\n".join(",".join(repr(float(x)) for x in row) for row in rows[2:])
        (folder / "base.csv").write_text("time_s,roll,pitch,yaw\n" + text + "\n")
        section = {"motion": "recorded", "file": str(folder / "base.csv")}
    model = antenna(**section)
    for axis in model.axes:
        model = model.with_number(axis, "thermal.ambient", WARM_DEGC)
    return model


@pytest.mark.parametrize("name", CASES)
def test_the_motion_of_the_second_antenna_comes_out_here_with_the_effect_and_not_without(
    name: str, tmp_path: Path
) -> None:
    row, body, parameters, moving = CASES[name]
    base = SWAY if moving else TILT
    theirs = second_antenna(row, body, base)
    model = here(base, tmp_path)

    def missed(model: AntennaModel) -> tuple[float, float]:
        ours = Plant(model).run(theirs[:, :2])
        return float(np.abs(ours.encoder[:, 0] - theirs[:, 2]).max()), float(
            np.abs(ours.gyro[:, 0] - theirs[:, 4]).max()
        )

    without, with_it = missed(model), missed(model.with_effect(name, "outer", parameters))
    # open loop for three seconds: what is left is the two integrators' difference
    assert with_it[0] < 5e-5 and with_it[1] < 5e-4
    assert without[0] > 50.0 * with_it[0] or without[1] > 50.0 * with_it[1]
