"""What varies by itself while a log is taken: friction levels that wander or switch, offsets that drift, torque that
drops out.
"""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from tests.blind.antenna import DRIFT, DRIVE, LEVEL, STILL

Array = np.ndarray


def still(rows: int) -> Array:
    """(rows, 2, 3): nothing varies."""
    return np.tile(STILL, (rows, 2, 1))


def wandering(rng: Generator, rows: int, dt: float, share: float, time_constant_s: float) -> Array:
    """An Ornstein-Uhlenbeck process of standard deviation `share`, (rows,)."""
    from scipy.signal import lfilter

    keep = float(np.exp(-dt / time_constant_s))
    kicks = rng.normal(0.0, share * np.sqrt(1.0 - keep * keep), rows)
    kicks[0] = rng.normal(0.0, share)
    return np.asarray(lfilter([1.0], [1.0, -keep], kicks))


def add_wander(weather: Array, rng: Generator, dt: float, shapes: list[tuple[float, float, float]]) -> None:
    """Per axis (share of the friction level, its time constant in s, drift of the torque's offset in N m), new in every
    log.
    """
    for a, (share, time_constant_s, drift_nm) in enumerate(shapes):
        weather[:, a, LEVEL] *= 1.0 + wandering(rng, len(weather), dt, share, time_constant_s)
        weather[:, a, DRIFT] += wandering(rng, len(weather), dt, drift_nm, 40.0)


def add_switching(weather: Array, rng: Generator, dt: float, a: int, size: float) -> None:
    """Friction jumps between two levels at random moments, every few seconds."""
    turns = np.cumsum(rng.random(len(weather)) < 0.3 * dt)
    weather[:, a, LEVEL] *= 1.0 + size * np.where((turns + int(rng.integers(2))) % 2, 1.0, -1.0)


def add_dropouts(weather: Array, rng: Generator, dt: float, a: int, size: float) -> None:
    """The drive loses a part of its torque for 15 to 80 ms, every few seconds."""
    at = 2.0
    while at < len(weather) * dt:
        first = int(at / dt)
        weather[first : first + max(1, int(rng.uniform(0.015, 0.08) / dt)), a, DRIVE] = 1.0 - min(1.0, size)
        at += float(rng.exponential(2.5)) + 0.2
