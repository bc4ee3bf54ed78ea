"""Encoder and gyro: what the electronics report of the true motion."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.layout import (
    ENCODER_NOISE,
    ENCODER_STEP,
    GYRO_A11,
    GYRO_A12,
    GYRO_A21,
    GYRO_A22,
    GYRO_B1,
    GYRO_B2,
    GYRO_BIAS,
    GYRO_FILTER,
    GYRO_NOISE,
    GYRO_SCALE_ERROR,
    GYRO_STATE,
    GYRO_STEP,
)
from sim_backend.noise import normal

_ENCODER_CHANNEL, _GYRO_CHANNEL = 0, 2


@compiled
def encoder_reading(P: np.ndarray, block: int, seed: int, tick: int, axis: int, position: float) -> float:
    """Position (rad) as the encoder reports it: noise, then the nearest step."""
    if P[block + ENCODER_NOISE] > 0.0:
        position += P[block + ENCODER_NOISE] * normal(seed, tick, _ENCODER_CHANNEL + axis)
    return quantised(position, P[block + ENCODER_STEP])


@compiled
def gyro_step(P: np.ndarray, block: int, state: tuple[float, float], rate: float) -> tuple[float, float]:
    """State of the gyro's second-order lag one plant step later, at inertial rate `rate` (rad/s); the same when it is
    ideal.
    """
    if P[block + GYRO_FILTER] > 0.0:
        x1, x2 = state
        return (
            P[block + GYRO_A11] * x1 + P[block + GYRO_A12] * x2 + P[block + GYRO_B1] * rate,
            P[block + GYRO_A21] * x1 + P[block + GYRO_A22] * x2 + P[block + GYRO_B2] * rate,
        )
    return state


@compiled
def gyro_reading(P: np.ndarray, block: int, X: np.ndarray, seed: int, tick: int, axis: int, rate: float) -> float:
    """Inertial rate (rad/s) as the gyro reports it: lag, scale, bias, noise, then the nearest step."""
    if P[block + GYRO_FILTER] > 0.0:
        rate = X[GYRO_STATE + 2 * axis]
    rate = (1.0 + P[block + GYRO_SCALE_ERROR]) * rate + P[block + GYRO_BIAS]
    if P[block + GYRO_NOISE] > 0.0:
        rate += P[block + GYRO_NOISE] * normal(seed, tick, _GYRO_CHANNEL + axis)
    return quantised(rate, P[block + GYRO_STEP])


@compiled
def quantised(value: float, step: float) -> float:
    """The nearest multiple of step; the value itself where step is 0."""
    if step > 0.0:
        return float(np.floor(value / step + 0.5) * step)
    return value
