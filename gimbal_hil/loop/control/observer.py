"""Kalman observer of one joint, and the loops that it closes: position, rate and disturbance from encoder, gyro, the
navigation's base rate and the torque that was sent.

States: joint position q, joint rate v, disturbance w as an acceleration (a random walk), offset o of the gyro against
joint and base rate (bias, and what the navigation is wrong by; a random walk), and the gyro's lag. A torque acts
DELAY_TICKS after it was sent; the loops work on the state predicted to then, so the known delay takes no phase. The
disturbance is taken off the torque and stands in for both integrators.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from gimbal_hil.loop.control.layout import (
    DELAY_TICKS,
    DRAG,
    EST_DISTURBANCE,
    EST_GYRO,
    EST_GYRO_SLOPE,
    EST_OFFSET,
    EST_POSITION,
    EST_RATE,
    ESTIMATE,
    FORESEEN,
    GYRO_LAG,
    JUMP,
    LAST_FEEDBACK,
    LOOP_ERROR,
    LOOP_REFERENCE,
    MOST_DELAY_TICKS,
    MOVED_INERTIA,
    OBSERVER_GAIN,
    OBSERVER_POSITION_KP,
    OBSERVER_RATE_KP,
    OBSERVER_STATES,
    PENDING,
    RATE_REFERENCE_LIMIT,
    SHAPED_ACCELERATION,
    SHAPED_POSITION,
    SHAPED_RATE,
    TORQUE,
    TORQUE_LIMIT,
    TORQUE_SCALE,
    Mode,
)
from gimbal_hil.loop.control.pi import clamp

_POSITION, _INERTIAL_RATE = int(Mode.POSITION), int(Mode.INERTIAL_RATE)


@compiled
def start_observing(position: float, rate: float, base_rate: float, step_s: float, H: np.ndarray, h: int) -> None:
    """Begin a tick before the one whose sample is about to be observed, where a joint of this rate was then, with the
    disturbance that balances the torque of the last tick: the first torque at zero error is the last one.
    """
    net = (H[h + TORQUE] - H[h + DRAG]) / H[h + MOVED_INERTIA]
    H[h + EST_RATE] = rate - base_rate
    H[h + EST_POSITION] = position - step_s * H[h + EST_RATE]
    H[h + EST_DISTURBANCE], H[h + EST_OFFSET] = -net, 0.0
    H[h + EST_GYRO], H[h + EST_GYRO_SLOPE] = rate, 0.0
    H[h + LAST_FEEDBACK] = H[h + FORESEEN] = np.nan
    for k in range(MOST_DELAY_TICKS + 1):
        H[h + PENDING + k] = net


@compiled
def observe(
    position: float, rate: float, base_rate: float, step_s: float, H: np.ndarray, h: int, C: np.ndarray, c: int
) -> None:
    """Estimates of this tick from encoder (rad), gyro (rad/s) and the base rate about the axis (rad/s)."""
    _predict(base_rate, step_s, H, h, C, c)
    of_encoder, of_gyro = position - H[h + EST_POSITION], rate - H[h + EST_GYRO]
    for k in range(OBSERVER_STATES):
        gain = c + OBSERVER_GAIN + 2 * k
        H[h + ESTIMATE + k] += C[gain] * of_encoder + C[gain + 1] * of_gyro


@compiled
def carry_on(base_rate: float, step_s: float, H: np.ndarray, h: int, C: np.ndarray, c: int) -> None:
    """Estimates of a tick that brought no sample and in which the last torque was held: what is not carried on would
    be taken for a jump of the joint when the next sample comes.
    """
    _predict(base_rate, step_s, H, h, C, c)
    remember_torque(H, h)


@compiled
def _predict(base_rate: float, step_s: float, H: np.ndarray, h: int, C: np.ndarray, c: int) -> None:
    """Estimates from those of the tick before and the torque that acted since."""
    acceleration = H[h + PENDING + int(C[c + DELAY_TICKS])] + H[h + EST_DISTURBANCE]
    before = H[h + EST_RATE]
    H[h + EST_POSITION] += step_s * (before + 0.5 * step_s * acceleration)
    H[h + EST_RATE] = before + step_s * acceleration
    if C[c + GYRO_LAG] == 0.0:
        H[h + EST_GYRO] = H[h + EST_RATE] + base_rate + H[h + EST_OFFSET]
    else:
        # over the tick, the mean of what the gyro was turned at
        turned = 0.5 * (before + H[h + EST_RATE]) + base_rate + H[h + EST_OFFSET]
        x1, x2, g = H[h + EST_GYRO], H[h + EST_GYRO_SLOPE], c + GYRO_LAG
        H[h + EST_GYRO] = C[g] * x1 + C[g + 1] * x2 + C[g + 4] * turned
        H[h + EST_GYRO_SLOPE] = C[g + 2] * x1 + C[g + 3] * x2 + C[g + 5] * turned


@compiled
def observed_torque(
    mode: int,
    reference: float,
    base_rate: float,
    allowed: tuple[float, float],
    step_s: float,
    H: np.ndarray,
    h: int,
    C: np.ndarray,
    c: int,
) -> float:
    """Torque (N m) of one axis from the estimates: position error to rate, rate error to torque, less the disturbance.

    Position follows the shaped reference; `reference` is in rad/s in the modes of a rate; `allowed` as in
    `axis_torque`.
    """
    delay = int(C[c + DELAY_TICKS])
    ahead = delay * step_s
    q, v = H[h + EST_POSITION], H[h + EST_RATE]
    for k in range(delay - 1, -1, -1):
        acceleration = H[h + PENDING + k] + H[h + EST_DISTURBANCE]
        q += step_s * (v + 0.5 * step_s * acceleration)
        v += step_s * acceleration
    curve = H[h + SHAPED_ACCELERATION]
    if mode == _POSITION:
        there = H[h + SHAPED_POSITION] + ahead * (H[h + SHAPED_RATE] + 0.5 * ahead * curve)
        low, high = max(-C[c + RATE_REFERENCE_LIMIT], allowed[0]), min(C[c + RATE_REFERENCE_LIMIT], allowed[1])
        wanted = clamp(C[c + OBSERVER_POSITION_KP] * (there - q) + H[h + SHAPED_RATE] + ahead * curve, low, high)
        H[h + LOOP_REFERENCE], H[h + LOOP_ERROR] = H[h + SHAPED_POSITION], H[h + SHAPED_POSITION] - H[h + EST_POSITION]
        asked = C[c + OBSERVER_POSITION_KP] * there + H[h + SHAPED_RATE] + ahead * curve
        drift = C[c + OBSERVER_POSITION_KP] * (H[h + SHAPED_RATE] + ahead * curve) + curve
    else:
        wanted, drift = reference, curve
        if mode == _INERTIAL_RATE:
            wanted -= base_rate + H[h + EST_OFFSET]
        H[h + LOOP_REFERENCE], H[h + LOOP_ERROR] = reference, wanted - H[h + EST_RATE]
        asked = wanted
    inertia, limit, kp = H[h + MOVED_INERTIA], C[c + TORQUE_LIMIT], C[c + TORQUE_SCALE] * C[c + OBSERVER_RATE_KP]
    H[h + JUMP], H[h + FORESEEN] = kp * (asked - H[h + FORESEEN]), asked + step_s * drift
    torque = kp * (wanted - v) + inertia * (curve - H[h + EST_DISTURBANCE]) + H[h + DRAG]
    H[h + TORQUE] = clamp(torque, -limit, limit)
    return float(H[h + TORQUE])


@compiled
def remember_torque(H: np.ndarray, h: int) -> None:
    """Keep what the torque of this tick is to bring, for the ticks until it acts."""
    for k in range(MOST_DELAY_TICKS, 0, -1):
        H[h + PENDING + k] = H[h + PENDING + k - 1]
    H[h + PENDING] = (H[h + TORQUE] - H[h + DRAG]) / H[h + MOVED_INERTIA]
