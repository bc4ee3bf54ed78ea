"""The observer: its gains are the steady Kalman filter's, its estimates those of the joint, late torque or not."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import solve_discrete_lyapunov

from gimbal_hil.loop.control import (
    Mode,
    ObservedJoint,
    layout,
    observe,
    observed_torque,
    remember_torque,
    start_observing,
)
from sim_backend.model import gyro_filter

STEP_S = 1e-3
LAG = gyro_filter(2.0 * np.pi * 200.0, 0.7, STEP_S)
JOINT = ObservedJoint(STEP_S, 4.3e-7, 2e-4, 150.0, 0.003, LAG)


def spread(joint: ObservedJoint, K: np.ndarray) -> np.ndarray:
    """Variances (6,) of the estimates in the long run under gains K, by the discrete Lyapunov equation; rad in urad."""
    A, H = joint.transition(), np.zeros((2, 6))
    H[0, 0] = H[1, 4] = 1.0
    Q = np.zeros((6, 6))
    Q[1, 1] = (joint.encoder_noise_rad * joint.bandwidth_rad_s**3 * STEP_S / joint.gusts_above_rad_s) ** 2
    Q[2, 2] = joint.encoder_noise_rad**2 * STEP_S * joint.bandwidth_rad_s**6 * STEP_S
    Q[3, 3] = joint.offset_walk_rad_s**2 * STEP_S
    R = np.diag([joint.encoder_noise_rad**2, joint.gyro_noise_rad_s**2])
    kept = np.eye(6) - K @ H
    return np.diag(solve_discrete_lyapunov(kept @ A, 1e12 * (kept @ Q @ kept.T + K @ R @ K.T)))


@pytest.mark.parametrize("gusts_above", [np.inf, 60.0])
@pytest.mark.parametrize("lag", [LAG, (0.0,) * 6])
def test_no_other_gains_estimate_better(lag: tuple[float, ...], gusts_above: float) -> None:
    joint = ObservedJoint(STEP_S, 4.3e-7, 2e-4, 150.0, 0.003, lag, gusts_above)
    K = joint.gains()
    best = spread(joint, K)[:4]
    draw = np.random.default_rng(1)
    for _ in range(20):
        other = spread(joint, K * (1.0 + 0.1 * draw.standard_normal(K.shape)))[:4]
        assert np.all(other >= best * (1.0 - 1e-6))
        assert np.any(other > best * (1.0 + 1e-4))


def law(delay: int) -> np.ndarray:
    """Parameters of an axis of 0.5 kg m^2 with the shipped gains."""
    C = np.zeros(layout.CONTROL_PARAMETERS)
    C[layout.OBSERVER_POSITION_KP], C[layout.OBSERVER_RATE_KP], C[layout.TORQUE_SCALE] = 20.0, 60.0, 1.0
    C[layout.RATE_REFERENCE_LIMIT], C[layout.TORQUE_LIMIT] = 3.0, 15.5
    C[layout.DELAY_TICKS] = delay
    C[layout.GYRO_LAG : layout.GYRO_LAG + 6] = LAG
    C[layout.OBSERVER_GAIN : layout.OBSERVER_GAIN + 12] = JOINT.gains().ravel()
    return C


def closed_loop(
    delay: int, disturbance_nm: float, bias_rad_s: float, ticks: int = 3000
) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n,) of a joint that is held at zero under a disturbance and a gyro with a bias, and the state."""
    H, C = np.zeros(layout.CONTROL_STATES), law(delay)
    H[layout.MOVED_INERTIA] = 0.5
    q = v = 0.0
    gyro, late, positions = np.zeros(2), [0.0] * delay, []
    start_observing(0.0, 0.0, 0.0, STEP_S, H, 0)
    for _ in range(ticks):
        observe(q, gyro[0], 0.0, STEP_S, H, 0, C, 0)
        torque = observed_torque(int(Mode.POSITION), 0.0, 0.0, (-3.0, 3.0), STEP_S, H, 0, C, 0)
        remember_torque(H, 0)
        late.append(torque)
        a = (late.pop(0) + disturbance_nm) / 0.5
        turned = v + 0.5 * STEP_S * a + bias_rad_s
        gyro = np.array([[LAG[0], LAG[1]], [LAG[2], LAG[3]]]) @ gyro + np.array([LAG[4], LAG[5]]) * turned
        q, v = q + STEP_S * (v + 0.5 * STEP_S * a), v + STEP_S * a
        positions.append(q)
    return np.array(positions), H


@pytest.mark.parametrize("delay", [0, 2, 8])
def test_a_disturbance_is_estimated_and_taken_off_whatever_the_known_delay(delay: int) -> None:
    positions, H = closed_loop(delay, 1.0, 0.0)
    assert H[layout.EST_DISTURBANCE] == pytest.approx(2.0, rel=1e-3)
    assert abs(positions[-1]) < 1e-7
    assert np.abs(positions).max() < 5e-3


def test_a_bias_of_the_gyro_goes_into_its_offset_and_not_into_the_position() -> None:
    positions, H = closed_loop(2, 0.0, 1e-3, ticks=8000)
    assert H[layout.EST_OFFSET] == pytest.approx(1e-3, rel=0.02)
    assert abs(positions[-1]) < 1e-6


def test_the_first_torque_at_zero_error_is_the_last_one() -> None:
    H, C = np.zeros(layout.CONTROL_STATES), law(2)
    H[layout.MOVED_INERTIA], H[layout.DRAG], H[layout.TORQUE] = 0.5, 0.7, 1.9
    H[layout.SHAPED_POSITION] = 0.3
    start_observing(0.3, 0.0, 0.0, STEP_S, H, 0)
    observe(0.3, 0.0, 0.0, STEP_S, H, 0, C, 0)
    assert observed_torque(int(Mode.POSITION), 0.3, 0.0, (-3.0, 3.0), STEP_S, H, 0, C, 0) == pytest.approx(1.9)
