"""A single axis with hidden truth: LuGre friction, gravity and ripple, under a rate loop or open loop, with encoder and
gyro.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from firmware_protocol.compiling import entry_point
from gimbal_hil.knowledge.identification import LugreFriction, StaticFriction
from sim_backend.friction import lugre_step, stribeck_level

OUTER = LugreFriction(StaticFriction(0.2585, 0.2412, 0.0054, 0.0609, 1.0459), 238.88, 16.02)
ENCODER_STEP = 2.0 * np.pi / 2**22
RATE_HZ = 1000.0


@dataclass(frozen=True)
class Rig:
    """Truth of one axis; `gravity` and `ripple` in N m, acting as gravity cos(q) and ripple sin(36 q)."""

    friction: LugreFriction = OUTER
    inertia: float = 0.5
    gravity: float = 0.0
    ripple: float = 0.0
    gyro_noise: float = 2e-4
    encoder_step: float = ENCODER_STEP


@dataclass(frozen=True)
class Recorded:
    """Columns at 1 kHz, each (n,)."""

    time_s: np.ndarray
    torque: np.ndarray
    position: np.ndarray
    gyro: np.ndarray
    rate_ref: np.ndarray


@entry_point
def _closed_loop(
    reference: np.ndarray,
    feed: np.ndarray,
    base_rate: np.ndarray,
    noise: np.ndarray,
    numbers: np.ndarray,
    steps: int,
    out: np.ndarray,
) -> None:
    """PI on the gyro where `feed` is NaN, else the torque in `feed`; out (n, 3): torque, position, gyro, all before the
    tick.
    """
    ts, tc, vs, sigma2, delta, sigma0, sigma1 = (
        numbers[0],
        numbers[1],
        numbers[2],
        numbers[3],
        numbers[4],
        numbers[5],
        numbers[6],
    )
    inertia, gravity, ripple, kp, ki = numbers[7], numbers[8], numbers[9], numbers[10], numbers[11]
    q, v, a, z, integral = 0.0, 0.0, 0.0, 0.0, numbers[12]
    h = 1e-3 / steps
    for k in range(reference.shape[0]):
        out[k, 1], out[k, 2] = q, v + base_rate[k] + noise[k]
        if np.isnan(feed[k]):
            error = reference[k] + base_rate[k] - out[k, 2]
            integral += ki * 1e-3 * error
            out[k, 0] = kp * error + integral
        else:
            out[k, 0] = feed[k]
        for _ in range(steps):
            middle, there = v + 0.5 * h * a, q + 0.5 * h * v
            level = stribeck_level(abs(middle), ts, tc, vs, delta)
            z, opposing = lugre_step(z, middle, h, level, sigma0, sigma1, sigma2)
            a = (out[k, 0] - opposing - gravity * np.cos(there) - ripple * np.sin(36.0 * there)) / inertia
            q += h * (v + 0.5 * h * a)
            v += h * a


def _record(rig: Rig, reference: np.ndarray, feed: np.ndarray, seed: int, base_rate: np.ndarray | None) -> Recorded:
    n = len(reference)
    noise = rig.gyro_noise * np.random.default_rng(seed).standard_normal(n)
    numbers = np.concatenate([rig.friction.values(), [rig.inertia, rig.gravity, rig.ripple, 60.0, 900.0, rig.gravity]])
    out = np.zeros((n, 3))
    _closed_loop(reference, feed, np.zeros(n) if base_rate is None else base_rate, noise, numbers, 10, out)
    encoder = np.round(out[:, 1] / rig.encoder_step) * rig.encoder_step
    return Recorded(np.arange(n) / RATE_HZ, out[:, 0], encoder, out[:, 2], reference)


def follow_rate(rig: Rig, reference: np.ndarray, seed: int, base_rate: np.ndarray | None = None) -> Recorded:
    """A rate loop on the gyro follows a joint-rate reference (n,); `base_rate` (n,) is what the base adds to the
    gyro.
    """
    return _record(rig, reference, np.full(len(reference), np.nan), seed, base_rate)


def apply_torque(rig: Rig, torque: np.ndarray) -> Recorded:
    """Open loop: torque (n,) held over each millisecond."""
    return _record(rig, np.zeros(len(torque)), torque, 0, None)


def there_and_back(speeds: Sequence[float], least_s: float = 5.0, least_rad: float = 0.02) -> np.ndarray:
    """Rate reference that goes each speed forth and back over the same stretch, with half a second of rest at the
    start.
    """
    pieces = [np.zeros(500)]
    for speed in speeds:
        rows = int(RATE_HZ * max(least_s, least_rad / speed))
        pieces += [np.full(rows, speed), np.full(rows, -speed)]
    return np.concatenate(pieces)


def plateau_rows(reference: np.ndarray) -> list[slice]:
    """Stretches of constant, non-zero reference."""
    edges = np.concatenate([[0], np.flatnonzero(np.diff(reference)) + 1, [len(reference)]])
    return [slice(int(a), int(b)) for a, b in pairwise(edges) if reference[a] != 0.0]


def slow_ramp(
    peak: float, seconds: float, points: Sequence[float] = (0.0, 1.0, 0.3, 0.7, -1.0, 0.6, 0.0)
) -> np.ndarray:
    """Torque through shares of `peak` at constant steepness overall, (n,)."""
    moments = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(points)))])
    time = np.arange(int(seconds * RATE_HZ)) / RATE_HZ
    return np.interp(time, moments / moments[-1] * seconds, peak * np.array(points))


def pulses(level: float, seconds: float) -> np.ndarray:
    """Torque pulses of both signs and two lengths within presliding, (n,)."""
    time = np.arange(int(seconds * RATE_HZ)) / RATE_HZ
    wave = np.where(time % 2.0 < 0.5, 1.0, 0.0) - np.where((time % 2.0 >= 1.0) & (time % 2.0 < 1.25), 0.7, 0.0)
    return np.where(time < 0.2, 0.0, level * wave)


def reversing_multisine(level: float, seconds: float, seed: int = 0) -> np.ndarray:
    """Torque multisine with random phases, faded in from rest, (n,)."""
    time = np.arange(int(seconds * RATE_HZ)) / RATE_HZ
    frequencies = np.array([0.2, 0.5, 1.1, 1.9, 3.1])
    phases = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, len(frequencies))
    wave = np.sin(2.0 * np.pi * np.outer(time, frequencies) + phases).sum(axis=1) / np.sqrt(len(frequencies))
    return np.asarray(level * wave * np.minimum(1.0, time))
