"""Base rates, gravity and friction compensation against an independent calculation with rotation matrices."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gimbal_hil.loop.control import base_rates, friction_torque, gravity_in_base, gravity_torques
from gimbal_hil.loop.control.layout import COULOMB, MOMENT_X, SIGN_WIDTH, VISCOUS
from gimbal_hil.loop.host import layout

ANGLES = st.floats(-3.0, 3.0)
OUTER, INNER = layout.axis_c(0), layout.axis_c(1)


def turn(axis: str, angle: float) -> np.ndarray:
    """Rotation matrix about a coordinate axis."""
    c, s = math.cos(angle), math.sin(angle)
    return {
        "x": np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
        "y": np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
        "z": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
    }[axis]


@given(ANGLES, ANGLES, ANGLES, ANGLES)
def test_gravity_compensation_balances_the_moment_about_each_joint(
    azimuth: float, elevation: float, roll: float, pitch: float
) -> None:
    C = np.zeros(layout.C_SIZE)
    outer_moment, inner_moment = np.array([0.93, -0.21, -0.26]), np.array([0.106, -0.005, 0.039])
    C[OUTER + MOMENT_X : OUTER + MOMENT_X + 3], C[INNER + MOMENT_X : INNER + MOMENT_X + 3] = outer_moment, inner_moment
    down = np.array([0.0, 0.0, -9.81])
    in_outer = (turn("y", pitch) @ turn("x", roll) @ turn("z", azimuth)).T @ down
    moment = outer_moment + turn("y", elevation) @ inner_moment
    torque = gravity_torques(azimuth, elevation, gravity_in_base(roll, pitch), C, OUTER + MOMENT_X, INNER + MOMENT_X)
    assert torque[0] == pytest.approx(-np.cross(moment, in_outer)[2], abs=1e-9)
    assert torque[1] == pytest.approx(-np.cross(turn("y", elevation) @ inner_moment, in_outer)[1], abs=1e-9)


@given(ANGLES, ANGLES, ANGLES, ANGLES)
def test_base_rates_are_the_parts_of_the_base_rate_along_the_axes(azimuth: float, p: float, q: float, r: float) -> None:
    seen = turn("z", azimuth).T @ np.array([p, q, r])
    outer, inner = base_rates(azimuth, p, q, r)
    assert outer == pytest.approx(seen[2], abs=1e-12)
    assert inner == pytest.approx(seen[1], abs=1e-12)


def test_friction_compensation_is_coulomb_and_viscous_and_smooth_through_zero() -> None:
    C = np.zeros(layout.C_SIZE)
    assert friction_torque(1.0, C, OUTER) == 0.0
    C[OUTER + COULOMB], C[OUTER + VISCOUS], C[OUTER + SIGN_WIDTH] = 0.24, 0.06, 0.005
    assert friction_torque(0.0, C, OUTER) == 0.0
    assert friction_torque(0.5, C, OUTER) == pytest.approx(0.27, abs=1e-9)
    assert friction_torque(-0.5, C, OUTER) == pytest.approx(-0.27, abs=1e-9)
