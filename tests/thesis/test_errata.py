"""The errata that need no table or switch, and the page that lists them all."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from gimbal_hil.proof.thesis.controller_tables import run_table
from gimbal_hil.proof.thesis.inferred import TILTED, ideal_sensors
from gimbal_hil.proof.thesis.printed import GAIN_TABLES
from sim_backend.model import shipped_model
from sim_backend.plant import Plant

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "explanation" / "reading-the-thesis.md"


def test_friction_opposes_the_joint_rate_and_not_the_inertial_one() -> None:
    # the base turns, the joint does not: no friction beyond the spring of the bristles
    model = ideal_sensors(shipped_model()).with_base({"motion": "constant_rate", "rate_rad_s": {"r": 1.0}})
    for axis in model.axes:
        model = model.with_numbers(axis, {f"body.cog.{key}": 0.0 for key in "xyz"})
    resting = Plant(model)
    motion = resting.run(np.zeros((300, 2)))
    assert np.abs(motion.friction[:, 0]).max() < 1e-3
    assert motion.gyro[-1, 0] == pytest.approx(1.0, abs=1e-3)
    # the joint turns against the base so that the body stands still in space: sliding friction
    held = Plant(model.with_number("outer", "start.rate", -1.0)).run(np.zeros((60, 2)))
    assert held.friction[-1, 0] < -0.2
    assert abs(held.gyro[0, 0]) < 1e-9


def test_the_shape_of_the_outer_stribeck_curve_is_that_of_tables_4_2_and_4_6() -> None:
    assert shipped_model().number("outer", "friction.shape") == 1.0459


def test_tables_5_4_and_5_5_share_a_row_that_settles_once() -> None:
    last = run_table(GAIN_TABLES[2], TILTED).rows[-1]
    shared = next(row for row in run_table(GAIN_TABLES[3], TILTED).rows if row.printed.swept == 300.0)
    assert last.settling_s == shared.settling_s and last.overshoot_percent == shared.overshoot_percent
    assert (last.printed.settling_s, shared.printed.settling_s) == (0.33, 0.30)
    assert last.settling_s == pytest.approx(0.30, abs=0.005)


def test_bristles_are_far_from_their_limit_while_displacement_is_small() -> None:
    # z' = v needs |z| << s(v)/sigma0, not |z| < s(v): the latter holds a thousand deflections beyond break-away
    friction = shipped_model()
    deflection = friction.number("outer", "friction.breakaway") / friction.number("outer", "friction.sigma0")
    assert deflection < 0.005 * friction.number("outer", "friction.coulomb")


def test_every_test_that_the_page_names_exists() -> None:
    named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", PAGE.read_text())
    assert len(named) >= 20
    for file, test in named:
        assert f"def {test}(" in (ROOT / file).read_text(), f"{file} has no {test}"
