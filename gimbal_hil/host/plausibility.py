"""Whether what the sensors say can be: gyro against encoder over a window, a gyro that repeats itself, feedback that
stands still behind live counters, and motion against the torque that should have made it.

Filled in with every feedback set; `implausible` judges it while torque is on.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from gimbal_hil.control import gravity_torques
from gimbal_hil.control.layout import TORQUE
from gimbal_hil.host.layout import (
    AXES,
    AXIS_C,
    AXIS_C_SIZE,
    AXIS_G,
    AXIS_G_SIZE,
    AXIS_H,
    AXIS_H_SIZE,
    BASE_GRAVITY,
    BASE_RATE,
    DEBOUNCE_TICKS,
    DEVICE_TICK,
    DISTURBANCE,
    DRIFT,
    DRIFT_KEPT,
    DRIFT_SHARE,
    DRIVE_LIMITS,
    EFFORT,
    ENCODER_SAME,
    EXPECTED_INERTIA,
    EXPECTED_MOMENT,
    EXPECTS_WEIGHT,
    GYRO_QUIET_CHANGES,
    GYRO_QUIET_TICKS,
    GYRO_SAME,
    LAST_JOINT_RATE,
    LAST_POSITION,
    LAST_RATE,
    LATE_S,
    MAX_DRIFT,
    MEASURED_POSITION,
    MEASURED_RATE,
    MODE,
    MODEL_SHARE,
    MOMENTUM,
    MOMENTUM_KEPT,
    PATH,
    PEAK_TORQUE,
    REST_RATE,
    STATUS_SAME,
    STEP_S,
    STUCK_TICKS,
)
from gimbal_hil.host.states import Cause, number

_NONE, _DRIFT, _STUCK = number(Cause.NONE), number(Cause.SENSOR_DRIFT), number(Cause.GYRO_STUCK)
_FROZEN, _RUNAWAY = number(Cause.FEEDBACK_FROZEN), number(Cause.RUNAWAY)
#: a gyro with noise is known by it: it changed in half of at least so many samples taken at rest without torque;
#: counting ends
_QUIET_LEAST, _QUIET_MOST = 10, 10000
_INNER = AXIS_H + AXIS_H_SIZE
_MOMENTS = (AXIS_C + EXPECTED_MOMENT, AXIS_C + AXIS_C_SIZE + EXPECTED_MOMENT)


@compiled
def watch_status(mail: np.ndarray, G: np.ndarray) -> None:
    """Count the feedback sets in a row whose device tick stood still."""
    tick = mail[m.DRIVE_STATUS_TICK]
    G[STATUS_SAME] = G[STATUS_SAME] + 1 if tick == G[DEVICE_TICK] else 0
    G[DEVICE_TICK] = tick


@compiled
def watch_sensors(H: np.ndarray, G: np.ndarray, C: np.ndarray, begin: bool, ticks: int) -> None:
    """Take in a fresh sample, `ticks` after the one before; `begin` when there was none for long. Call before
    LAST_POSITION moves on.

    DRIFT: what encoder and gyro have moved apart (rad), forgotten with the window's time constant; PATH: how far the
    axis went meanwhile. MOMENTUM: what the axis gained beyond the impulse of its torque and its weight (N m s), EFFORT:
    the size of the torque's impulse, PEAK_TORQUE: its largest size, all over a short window.
    """
    dt = C[STEP_S] * ticks
    weights = _weights(H, G, C)
    for axis in range(AXES):
        h, c, g = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE, AXIS_G + axis * AXIS_G_SIZE
        rate = H[h + MEASURED_RATE]
        joint = rate - H[h + BASE_RATE]
        if begin:
            H[h + DRIFT] = H[h + PATH] = H[h + MOMENTUM] = H[h + EFFORT] = H[h + PEAK_TORQUE] = 0.0
            G[g + GYRO_SAME] = G[g + ENCODER_SAME] = 0
        else:
            moved, turned = H[h + MEASURED_POSITION] - H[h + LAST_POSITION], 0.5 * (joint + H[h + LAST_JOINT_RATE]) * dt
            H[h + DRIFT] = C[DRIFT_KEPT] * H[h + DRIFT] + (moved - turned)
            H[h + PATH] = C[DRIFT_KEPT] * H[h + PATH] + max(abs(moved), abs(turned))
            impulse = _acting_torque(H, G, axis) * dt
            gained = C[c + EXPECTED_INERTIA] * (rate - H[h + LAST_RATE]) - impulse - weights[axis] * dt
            H[h + MOMENTUM] = C[MOMENTUM_KEPT] * H[h + MOMENTUM] + gained
            H[h + EFFORT] = C[MOMENTUM_KEPT] * H[h + EFFORT] + abs(impulse)
            H[h + PEAK_TORQUE] = max(C[MOMENTUM_KEPT] * H[h + PEAK_TORQUE], abs(H[h + TORQUE]))
            if G[g + MODE] == 0:
                # what moves an axis that is off is not this host's torque
                H[h + MOMENTUM] = H[h + EFFORT] = H[h + PEAK_TORQUE] = 0.0
            changed = rate != H[h + LAST_RATE]
            G[g + GYRO_SAME] = 0 if changed else G[g + GYRO_SAME] + 1
            G[g + ENCODER_SAME] = 0 if moved != 0.0 else G[g + ENCODER_SAME] + 1
            if G[g + MODE] == 0 and abs(rate) < C[c + REST_RATE] and G[g + GYRO_QUIET_TICKS] < _QUIET_MOST:
                G[g + GYRO_QUIET_TICKS] += 1
                G[g + GYRO_QUIET_CHANGES] += 1 if changed else 0
        H[h + LAST_RATE], H[h + LAST_JOINT_RATE] = rate, joint


@compiled
def implausible(H: np.ndarray, G: np.ndarray, C: np.ndarray, axis: int) -> int:
    """The Cause that the sensors of an axis give to stop without them, NONE when all is well."""
    h, c, g = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE, AXIS_G + axis * AXIS_G_SIZE
    if G[STATUS_SAME] >= C[DEBOUNCE_TICKS]:
        return _FROZEN
    if C[c + STUCK_TICKS] > 0.0 and G[g + GYRO_SAME] >= C[c + STUCK_TICKS] and _is_noisy(G, g):
        return _FROZEN if G[g + ENCODER_SAME] >= C[c + STUCK_TICKS] else _STUCK
    # one gyro reads a part of the other's rate, and its scale is not exact
    path = H[AXIS_H + PATH] + H[AXIS_H + AXIS_H_SIZE + PATH]
    if abs(H[h + DRIFT]) > C[c + MAX_DRIFT] + C[DRIFT_SHARE] * path:
        return _DRIFT
    # a torque that changes acts some ticks late
    allowed = C[c + DISTURBANCE] + C[MODEL_SHARE] * H[h + EFFORT] + C[LATE_S] * H[h + PEAK_TORQUE]
    return _RUNAWAY if C[c + EXPECTED_INERTIA] > 0.0 and abs(H[h + MOMENTUM]) > allowed else _NONE


@compiled
def _acting_torque(H: np.ndarray, G: np.ndarray, axis: int) -> float:
    """The torque (N m) asked of an axis, or what the drive says that it makes of it: beyond its limits of travel and
    rate it cuts what leads on.
    """
    h = AXIS_H + axis * AXIS_H_SIZE
    torque, limits = H[h + TORQUE], G[DRIVE_LIMITS]
    if limits == 0:
        return float(torque)
    side = m.LIMIT_FLAGS_OUTER_TRAVEL_HIGH if torque > 0.0 else m.LIMIT_FLAGS_OUTER_TRAVEL_LOW
    too_fast = limits & (m.LIMIT_FLAGS_OUTER_RATE << axis) and torque * (H[h + MEASURED_RATE] - H[h + BASE_RATE]) > 0.0
    return 0.0 if too_fast or limits & (side << (2 * axis)) else float(torque)


@compiled
def _weights(H: np.ndarray, G: np.ndarray, C: np.ndarray) -> tuple[float, float]:
    """Torques (N m) of both bodies' weight about their axes on the base as it stands and moves; zero while nothing is
    under torque.
    """
    if C[EXPECTS_WEIGHT] == 0.0 or (G[AXIS_G + MODE] == 0 and G[AXIS_G + AXIS_G_SIZE + MODE] == 0):
        return 0.0, 0.0
    gravity = (H[BASE_GRAVITY], H[BASE_GRAVITY + 1], H[BASE_GRAVITY + 2])
    positions = H[AXIS_H + MEASURED_POSITION], H[_INNER + MEASURED_POSITION]
    outer, inner = gravity_torques(positions[0], positions[1], gravity, C, _MOMENTS[0], _MOMENTS[1])
    return -outer, -inner


@compiled
def _is_noisy(G: np.ndarray, g: int) -> bool:
    return bool(G[g + GYRO_QUIET_TICKS] >= _QUIET_LEAST and 2 * G[g + GYRO_QUIET_CHANGES] >= G[g + GYRO_QUIET_TICKS])
