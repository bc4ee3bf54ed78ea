"""Joint positions and MAVLink's attitudes against pymavlink's own rotations, which have MAVLink's axes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.quaternion import QuaternionBase
from scipy.spatial.transform import Rotation

from gimbal_hil.realtime.mavlink.angles import direction_rad, nearest_turn, quaternion
from gimbal_hil.realtime.mavlink.values import NOT_TOLD, Reach, Wish
from sim_backend.boresight import Boresight

ANGLES = st.floats(-math.pi + 1e-3, math.pi - 1e-3)
ELEVATIONS = st.floats(-1.5, 1.5)


@given(ANGLES, ELEVATIONS)
def test_on_a_level_base_yaw_is_minus_the_outer_joint_and_pitch_minus_the_inner(outer: float, inner: float) -> None:
    roll, pitch, yaw = QuaternionBase(list(quaternion((outer, inner), None, False))).euler
    assert (pitch, yaw) == pytest.approx((-inner, -outer), abs=1e-9) and abs(roll) < 1e-9


def test_the_antenna_looks_up_and_right_where_mavlink_says_pitch_and_yaw_are_positive() -> None:
    q = QuaternionBase([math.radians(value) for value in (0.0, 30.0, 90.0)])
    direction = direction_rad(list(q.q), 0.0)
    assert direction == pytest.approx((-math.pi / 2.0, -math.radians(30.0)))


@given(ANGLES, ELEVATIONS, ANGLES, st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_direction_and_attitude_are_each_others_inverse_on_any_base(
    outer: float, inner: float, yaw: float, pitch: float, roll: float
) -> None:
    q = quaternion((outer, inner), (roll, pitch, yaw), True)
    direction = direction_rad(q, 0.0)
    assert direction is not None
    # the boresight by plain matrices, R_eb = Rz(yaw) Ry(pitch) Rx(roll) and the joints on it

    def z(a: float) -> np.ndarray:
        return np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])

    def y(a: float) -> np.ndarray:
        return np.array([[math.cos(a), 0, math.sin(a)], [0, 1, 0], [-math.sin(a), 0, math.cos(a)]])

    def x(a: float) -> np.ndarray:
        return np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])

    ahead = np.array([1.0, 0.0, 0.0])
    true = z(yaw) @ y(pitch) @ x(roll) @ z(outer) @ y(inner) @ ahead
    assert z(direction[0]) @ y(direction[1]) @ ahead == pytest.approx(true, abs=1e-7)


def test_yaw_from_the_vehicle_leaves_the_heading_out() -> None:
    _, _, yaw = QuaternionBase(list(quaternion((0.3, 0.0), (0.0, 0.0, 1.0), False))).euler
    _, _, from_north = QuaternionBase(list(quaternion((0.3, 0.0), (0.0, 0.0, 1.0), True))).euler
    assert (yaw, from_north) == pytest.approx((-0.3, -1.3))


@pytest.mark.parametrize("q", [(0.0, 0.0, 0.0, 0.0), (2.0, 0.0, 0.0, 0.0), (math.nan, 0.0, 0.0, 1.0)])
def test_what_is_no_attitude_is_no_direction(q: tuple[float, ...]) -> None:
    assert direction_rad(q, 0.0) is None


def test_straight_up_the_outer_joint_stays() -> None:
    up = quaternion((0.0, -math.pi / 2.0), None, False)
    assert direction_rad(up, 0.7) == pytest.approx((0.7, -math.pi / 2.0), abs=1e-6)


@given(ANGLES, st.floats(-20.0, 20.0))
def test_the_turn_is_the_nearest_one(angle: float, to: float) -> None:
    found = nearest_turn(angle, to, -math.inf, math.inf)
    assert abs(found - to) <= math.pi + 1e-9
    assert math.remainder(found - angle, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_a_turn_beyond_the_limits_is_not_taken() -> None:
    assert nearest_turn(3.0, -3.0, -3.2, 3.2) == 3.0
    assert nearest_turn(3.0, -3.0, -4.0, 4.0) == pytest.approx(3.0 - 2.0 * math.pi)


@given(ANGLES, ELEVATIONS, ANGLES, st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_an_antenna_that_looks_along_minus_x_is_told_as_it_looks_and_asked_back_to_where_it_is(
    outer: float, inner: float, yaw: float, pitch: float, roll: float
) -> None:
    seen = replace(NOT_TOLD, position_rad=(outer, inner), base_rad=(roll, pitch, yaw)).ahead(Boresight.ASTERN)
    q = quaternion(seen.position_rad, seen.base_rad, True)
    base = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    ahead, left, up = (base * Rotation.from_euler("ZY", [outer, inner])).apply([-1.0, 0.0, 0.0])
    w, x, y, z = q
    # MAVLink's axes are north, east, down
    north, east, down = Rotation.from_quat([x, y, z, w]).apply([1.0, 0.0, 0.0])
    assert (north, east, down) == pytest.approx((ahead, -left, -up), abs=1e-9)
    direction = direction_rad(q, 0.0)
    assert direction is not None
    wish = Wish("pointing", *direction).behind(Boresight.ASTERN)
    looks = Rotation.from_euler("ZY", [wish.outer, wish.inner]).apply([-1.0, 0.0, 0.0])
    assert looks == pytest.approx([ahead, left, up], abs=1e-6)


def test_joints_of_an_antenna_that_looks_along_minus_x_are_asked_for_with_their_own_signs() -> None:
    assert Wish("position", 0.3, -0.5, 2.0).behind(Boresight.ASTERN) == Wish("position", 0.3, 0.5, 2.0)
    assert Wish("rate", 0.3, -0.5).behind(Boresight.AHEAD) == Wish("rate", 0.3, -0.5)
    reach = Reach((-1.0, 0.0), (2.0, 1.57), (1.0, 1.0), (0.1, 0.2), Boresight.ASTERN).ahead()
    assert (reach.low_rad, reach.high_rad, reach.stow_rad) == ((-1.0, -1.57), (2.0, 0.0), (0.1, -0.2))
