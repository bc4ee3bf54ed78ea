"""Sensor effects: what encoder and gyro read of a motion that is known."""

from __future__ import annotations

import numpy as np

from sim_backend.plant import Plant
from tests.effects.rigs import RATE_HZ, antenna, rotary, run, with_effect


def test_encoder_eccentricity_errs_once_a_turn_and_leaves_the_motion_alone() -> None:
    model = rotary(0.5, start_rate=2.0)
    motion = run(with_effect(model, "encoder_eccentricity", amplitude=1e-3, phase=0.4), 0.0, 4000)
    q = motion.position[:, 0]
    np.testing.assert_allclose(motion.encoder[:, 0] - q, 1e-3 * np.sin(q + 0.4), atol=1e-15)
    assert motion.position.tobytes() == run(model, 0.0, 4000).position.tobytes()


def test_gyro_bias_and_scale_act_on_the_reading_only() -> None:
    model = rotary(0.5, start_rate=2.0)
    np.testing.assert_allclose(run(with_effect(model, "gyro_bias", bias=0.01), 0.0).gyro, 2.01, rtol=1e-12)
    np.testing.assert_allclose(run(with_effect(model, "gyro_scale", scale_error=0.02), 0.0).gyro, 2.04, rtol=1e-12)


def test_a_misaligned_gyro_reads_its_part_of_the_two_other_rates() -> None:
    base = {"motion": "constant_rate", "rate_rad_s": {"p": 0.3, "q": -0.2, "r": 0.1}}
    model = antenna(**base).with_number("outer", "start.position", 0.8).with_number("inner", "start.position", -0.5)
    leaks = {"leak_x": 0.05, "leak_y": 0.07, "leak_z": 0.11}
    askew = with_effect(
        with_effect(model, "gyro_misalignment", "outer", **leaks), "gyro_misalignment", "inner", **leaks
    )
    straight, leaked = Plant(model, RATE_HZ), Plant(askew, RATE_HZ)
    for _ in range(5):
        difference = leaked.run(np.ones((1, 2))).gyro - straight.run(np.ones((1, 2))).gyro
        outer, inner = leaked.body_rates
        np.testing.assert_allclose(difference[0, 0], 0.05 * outer[0] + 0.07 * outer[1], atol=1e-15)
        np.testing.assert_allclose(difference[0, 1], 0.05 * inner[0] + 0.11 * inner[2], atol=1e-15)


def test_a_misaligned_gyro_on_a_still_base_needs_the_other_axis_to_move() -> None:
    model = antenna()
    askew = with_effect(model, "gyro_misalignment", "inner", leak_x=0.1, leak_z=0.1)
    alone = np.column_stack([np.zeros(300), np.full(300, 1.5)])
    both = np.column_stack([np.full(300, 3.0), np.full(300, 1.5)])
    assert np.abs(run(askew, alone).gyro - run(model, alone).gyro).max() < 1e-3
    assert np.abs(run(askew, both).gyro - run(model, both).gyro).max() > 5e-2
