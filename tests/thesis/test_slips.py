"""Each slip as a switch, against the printed equations written out with matrices."""

from __future__ import annotations

import numpy as np
import pytest

from firmware_protocol.compiling import entry_point
from firmware_protocol.errors import BadInputError
from gimbal_hil.proof.thesis.inferred import LEVEL
from gimbal_hil.proof.thesis.slip_effects import WHERE, acceleration_errors
from sim_backend.layout import GRAVITY_READING, SLIPS, GravityReading
from sim_backend.model import model_from_document, plant_arrays, shipped_model
from sim_backend.plant import Plant
from sim_backend.thesis_slips import Slip, slip_torque

MODEL = LEVEL.antenna()
Z, Y = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])


@entry_point
def added(P: np.ndarray, K: np.ndarray, s: np.ndarray) -> tuple[float, float]:
    """Slip torque at a state (q, v, gravity, base rate, base acceleration)."""
    base = ((s[4], s[5], s[6]), (s[7], s[8], s[9]), (s[10], s[11], s[12]))
    return slip_torque(P, K, (s[0], s[1]), (s[2], s[3]), base)


def slip(which: Slip, state: np.ndarray, reading: GravityReading = GravityReading.SEPARATE_BODIES) -> np.ndarray:
    arrays = plant_arrays(MODEL)
    arrays.K[SLIPS], arrays.K[GRAVITY_READING] = int(which), reading
    return np.array(added(arrays.P, arrays.K, state))


def tensor(axis: str) -> np.ndarray:
    xx, yy, zz, xy, xz, yz = (MODEL.number(axis, f"body.inertia.{k}") for k in ("xx", "yy", "zz", "xy", "xz", "yz"))
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def cog(axis: str) -> np.ndarray:
    return np.array([MODEL.number(axis, f"body.cog.{k}") for k in "xyz"])


def cross(w: np.ndarray) -> np.ndarray:
    """Eq. 2.11: M_Omega."""
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def r_ob(eta: float) -> np.ndarray:
    """Eq. 2.6 transposed."""
    c, s = np.cos(eta), np.sin(eta)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def r_io(eps: float) -> np.ndarray:
    """Eq. 2.7 transposed."""
    c, s = np.cos(eps), np.sin(eps)
    return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])


def left_sides(state: np.ndarray, derivative_sign: float, elevation_rate_factor: bool) -> np.ndarray:
    """Left sides of eq. 2.52 (z row) and 2.40 (y row) at q'' = 0, with R_dot = sign M_omega R and either reading of
    R_oi_dot.
    """
    (eta, eps, deta, deps), w_b, a_b = state[:4], state[7:10], state[10:13]
    ob, io = r_ob(eta), r_io(eps)
    w_o = deta * Z + ob @ w_b
    w_i = deps * Y + io @ w_o
    ob_dot = derivative_sign * cross(deta * Z) @ ob
    io_dot = derivative_sign * cross(deps * Y) @ io
    a_o = ob @ a_b + ob_dot @ w_b
    a_i = io @ a_o + io_dot @ w_o
    inertia_o, inertia_i = tensor("outer"), tensor("inner")
    c, s = np.cos(eps), np.sin(eps)
    printed_oi_dot = np.array([[-s, 0.0, c], [0.0, 0.0, 0.0], [-c, 0.0, -s]])
    oi_dot = printed_oi_dot * (deps if elevation_rate_factor else 1.0)
    outer = (
        inertia_o @ a_o
        + oi_dot @ inertia_i @ w_i
        + io.T @ inertia_i @ a_i
        + np.cross(w_o, inertia_o @ w_o + io.T @ inertia_i @ w_i)
    )
    inner = inertia_i @ a_i + np.cross(w_i, inertia_i @ w_i)
    return np.array([outer[2], inner[1]])


STATES = np.random.default_rng(7).uniform(-1.0, 1.0, (40, 13)) * np.array(
    [3.0, 1.5, 2.0, 2.0, 6.0, 6.0, 6.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0]
)


@pytest.mark.parametrize("state", STATES[:20])
def test_the_missing_elevation_rate_adds_what_eq_2_58_adds(state: np.ndarray) -> None:
    expected = left_sides(state, -1.0, True) - left_sides(state, -1.0, False)
    np.testing.assert_allclose(slip(Slip.MISSING_ELEVATION_RATE, state), expected, atol=1e-13)


@pytest.mark.parametrize("state", STATES[:20])
def test_the_derivative_sign_adds_what_eq_2_22_and_2_23_add(state: np.ndarray) -> None:
    expected = left_sides(state, -1.0, True) - left_sides(state, 1.0, True)
    np.testing.assert_allclose(slip(Slip.DERIVATIVE_SIGN, state), expected, atol=1e-13)


def test_the_minus_sign_is_the_derivative_of_the_rotation() -> None:
    eta, deta, h = 0.7, 1.3, 1e-6
    true = (r_ob(eta + deta * h) - r_ob(eta - deta * h)) / (2.0 * h)
    np.testing.assert_allclose(-cross(deta * Z) @ r_ob(eta), true, atol=1e-9)
    assert np.abs(cross(deta * Z) @ r_ob(eta) - true).max() > 1.0


@pytest.mark.parametrize("reading", list(GravityReading))
@pytest.mark.parametrize("state", STATES[:10])
def test_eq_3_10_replaces_the_gravity_torque_by_the_y_row_with_the_total_mass(
    state: np.ndarray, reading: GravityReading
) -> None:
    (eta, eps), gravity = state[:2], state[4:7]
    g_o = r_ob(eta) @ gravity
    g_i = r_io(eps) @ g_o
    mass_o, mass_i = MODEL.number("outer", "body.mass"), MODEL.number("inner", "body.mass")
    r = cog("outer")
    printed = (mass_o + mass_i) * (r[2] * g_o[0] - g_o[2] * r[0])
    separate = np.cross(r, mass_o * g_o)[2] + (r_io(eps).T @ np.cross(cog("inner"), mass_i * g_i))[2]
    total = (mass_o + mass_i) * np.cross(r, g_o)[2]
    right = separate if reading is GravityReading.SEPARATE_BODIES else total
    np.testing.assert_allclose(slip(Slip.GRAVITY_ROW, state, reading), [printed - right, 0.0], atol=1e-12)


def test_inner_friction_on_the_outer_axis_is_the_inner_joints_own() -> None:
    state = np.zeros(13)
    state[3] = 0.5
    friction = 0.1376 + 0.0336 * 0.5
    np.testing.assert_allclose(slip(Slip.INNER_FRICTION_ON_OUTER, state), [-friction, 0.0], rtol=1e-9)


@pytest.mark.heavy
def test_friction_added_to_the_motors_torque_speeds_an_axis_up() -> None:
    document = shipped_model().document | {"thesis_slips": ["friction_added"]}
    model = model_from_document(document, "slip").with_number("outer", "start.rate", 0.5)
    right = shipped_model().with_number("outer", "start.rate", 0.5)
    assert Plant(model).run(np.zeros((200, 2))).rate[-1, 0] > 0.5 > Plant(right).run(np.zeros((200, 2))).rate[-1, 0]


def test_slips_add_up_and_no_slip_adds_nothing() -> None:
    for state in STATES[20:]:
        parts = sum(slip(one, state) for one in WHERE)
        np.testing.assert_allclose(slip(~Slip.NONE & sum_of_slips(), state), parts, atol=1e-12)
        np.testing.assert_array_equal(slip(Slip.NONE, state), [0.0, 0.0])


def sum_of_slips() -> Slip:
    every = Slip.NONE
    for one in WHERE:
        every |= one
    return every


def test_the_derivative_sign_is_the_worst_of_the_kinematic_slips() -> None:
    sign, rate = acceleration_errors(Slip.DERIVATIVE_SIGN), acceleration_errors(Slip.MISSING_ELEVATION_RATE)
    assert np.median(sign) == pytest.approx(0.066, abs=0.01) and sign.max() > 2.0
    assert rate.max() > 0.5 and np.median(rate) < np.median(sign)


def test_a_slip_that_does_not_exist_is_refused_by_name() -> None:
    document = shipped_model().document | {"thesis_slips": ["eq_3_10"]}
    with pytest.raises(BadInputError, match=r"no slip 'eq_3_10'.*gravity_row"):
        plant_arrays(model_from_document(document, "slip"))
