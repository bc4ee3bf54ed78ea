"""A model led along measured positions tells the torque that it lacks, and nothing where it lacks none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from sim_backend.base_motion import base_state
from sim_backend.layout import BASE_COLUMNS
from sim_backend.model import AntennaModel, model_from_document, shipped_model
from sim_backend.observer import (
    ELAPSED,
    ENCODER,
    FREE,
    GYRO,
    GYRO_ERROR,
    INPUTS,
    MEASURED,
    MISSING,
    TORQUE,
    TORQUE_BEFORE,
    ModelObserver,
)
from sim_backend.plant import Plant, Simulation

RATE_HZ, SECONDS = 1000.0, 12.0
COGGING_NM, ORDER, PHASE = 0.05, 8.0, 0.3


def with_cogging() -> AntennaModel:
    document: dict[str, Any] = dict(shipped_model().document)
    units = {"amplitude": (COGGING_NM, "N m"), "order": (ORDER, "1/turn"), "phase": (PHASE, "rad")}
    numbers = {name: {"value": value, "unit": unit, "source": "test"} for name, (value, unit) in units.items()}
    document["effects"] = [{"name": "cogging", "axis": "outer", **numbers}]
    return model_from_document(document, "cogging")


def slow_swing() -> tuple[np.ndarray, np.ndarray]:
    """Torques (n, 2) that swing both axes, and their times."""
    time_s = np.arange(round(SECONDS * RATE_HZ)) / RATE_HZ
    torque = np.stack([0.45 * np.sin(0.5 * np.pi * time_s), 0.5 * np.sin(1.4 * np.pi * time_s)], axis=1)
    return time_s, torque


def rows_of(simulation: Simulation, torque: np.ndarray) -> np.ndarray:
    rows = np.zeros((len(torque), INPUTS))
    rows[1:, ELAPSED] = rows[:, MEASURED] = rows[:, FREE] = 1.0
    rows[1:, TORQUE : TORQUE + 2], rows[2:, TORQUE_BEFORE : TORQUE_BEFORE + 2] = torque[:-1], torque[:-2]
    rows[:, ENCODER : ENCODER + 2], rows[:, GYRO : GYRO + 2] = simulation.encoder, simulation.gyro
    return rows


def rms(values: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(values**2, axis=0))


def test_the_right_model_lacks_nothing_beyond_its_sensors_noise() -> None:
    _, torque = slow_swing()
    simulation = Plant(shipped_model(), RATE_HZ, seed=3).run(torque)
    assert np.all(np.abs(simulation.position).max(axis=0) > 0.2), "the axes break away and move"
    told = ModelObserver(shipped_model(), RATE_HZ, 30.0).observe(rows_of(simulation, torque))[1000:]
    assert np.all(rms(told[:, MISSING : MISSING + 2]) < 1e-4)
    assert np.all(rms(told[:, GYRO_ERROR : GYRO_ERROR + 2]) < 5e-4)


def test_a_cogging_torque_is_told_with_its_size_and_sign_on_its_own_axis() -> None:
    _, torque = slow_swing()
    simulation = Plant(with_cogging(), RATE_HZ, seed=3).run(torque)
    told = ModelObserver(shipped_model(), RATE_HZ, 60.0).observe(rows_of(simulation, torque))
    there = COGGING_NM * np.sin(ORDER * simulation.position[:, 0] + PHASE)
    slow = np.abs(simulation.rate[:, 0]) < 0.5
    slow[:1000] = False
    assert slow.sum() > 2000
    assert np.corrcoef(told[slow, MISSING], there[slow])[0, 1] > 0.98
    assert rms(told[slow, MISSING]) == pytest.approx(rms(there[slow]), rel=0.1)
    assert rms(told[1000:, MISSING + 1]) < 1e-4


def test_ticks_that_were_not_heard_are_gone_through_with_the_torque_that_was_held() -> None:
    _, torque = slow_swing()
    torque = np.repeat(torque[::5], 5, axis=0)[: len(torque)]
    simulation = Plant(shipped_model(), RATE_HZ, seed=3).run(torque)
    rows = rows_of(simulation, torque)[::5].copy()
    rows[1:, ELAPSED] = 5.0
    # the torque of every one of the five ticks
    rows[:, TORQUE_BEFORE : TORQUE_BEFORE + 2] = rows[:, TORQUE : TORQUE + 2]
    told = ModelObserver(shipped_model(), RATE_HZ, 30.0).observe(rows)[200:]
    assert np.all(rms(told[:, MISSING : MISSING + 2]) < 1e-3)


def test_a_base_that_moves_is_no_missing_torque_once_it_is_told() -> None:
    document: dict[str, Any] = dict(shipped_model().document)
    document["base"] = {
        "motion": "sinusoid",
        "amplitude_rad": {"roll": 0.1, "pitch": 0.08, "yaw": 0.1},
        "frequency_hz": {"roll": 0.3, "pitch": 0.4, "yaw": 0.2},
    }
    model = model_from_document(document, "moving")
    time_s, torque = slow_swing()
    plant = Plant(model, RATE_HZ, seed=3)
    simulation = plant.run(torque)
    rows, told = rows_of(simulation, torque), []
    blind, heard = ModelObserver(shipped_model(), RATE_HZ, 30.0), ModelObserver(shipped_model(), RATE_HZ, 30.0)
    for k in range(0, len(rows), 10):
        gravity, rate, acceleration = base_state(plant.P, plant.K, float(time_s[k]))
        base = np.zeros(BASE_COLUMNS)
        # roll and pitch that give this gravity
        base[0], base[1] = np.arctan2(-gravity[1], -gravity[2]), np.arcsin(gravity[0] / 9.81)
        base[3:6], base[6:9] = rate, acceleration
        heard.base_is(base)
        told.append(heard.observe(rows[k : k + 10]))
    with_base = rms(np.concatenate(told)[1000:, MISSING : MISSING + 2])
    without = rms(blind.observe(rows)[1000:, MISSING : MISSING + 2])
    assert np.all(with_base < 0.05 * without) and np.all(without > 0.01)


def test_an_axis_without_torque_is_only_followed() -> None:
    _, torque = slow_swing()
    simulation = Plant(with_cogging(), RATE_HZ, seed=3).run(torque)
    rows = rows_of(simulation, torque)
    rows[:, FREE] = 0.0
    assert not ModelObserver(shipped_model(), RATE_HZ, 30.0).observe(rows).any()
