"""Reference trajectories and base motion of the bench, drawn from a random generator."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

Array = np.ndarray


def smooth_points(t: Array, times: Array, points: Array) -> Array:
    """Quintic moves between points, resting where two neighbours are equal; columns position, rate, acceleration."""
    k = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(times) - 2)
    span = times[k + 1] - times[k]
    s = np.clip((t - times[k]) / span, 0.0, 1.0)
    rise = points[k + 1] - points[k]
    position = points[k] + rise * (10 * s**3 - 15 * s**4 + 6 * s**5)
    rate = rise * (30 * s**2 - 60 * s**3 + 30 * s**4) / span
    return np.stack([position, rate, rise * (60 * s - 180 * s**2 + 120 * s**3) / span**2], axis=1)


def plateaus(t: Array, rng: Generator, fast: float, travel: float) -> Array:
    """Constant speeds in both directions, from creep to fast, with trapezoid corners of 0.25 s."""
    dt = t[1] - t[0]
    rate = np.zeros_like(t)
    at, position, sign = 0.6, 0.0, 1.0
    while at < t[-1] - 1.0:
        speed = float(np.exp(rng.uniform(np.log(0.004), np.log(fast))))
        length = float(min(rng.uniform(1.5, 3.5), travel / speed))
        if abs(position + sign * speed * length) > travel:
            sign = -sign
        inside = (t >= at) & (t < at + length)
        rate[inside] = sign * speed
        position += sign * speed * length
        sign = -sign if rng.random() < 0.75 else sign
        at += length + (rng.uniform(0.1, 0.4) if rng.random() < 0.3 else 0.0)
    kernel = np.hanning(int(0.25 / dt))
    rate = np.convolve(rate, kernel / kernel.sum(), mode="same")
    return np.stack([np.cumsum(rate) * dt, rate, np.gradient(rate, dt)], axis=1)


def multisine(t: Array, rng: Generator, fast: float, travel: float, top_hz: float, period_s: float) -> Array:
    """Random-phase sines on the lines of one period with a rate limit and a travel limit."""
    lines = np.unique(np.round(np.geomspace(1, max(2.0, top_hz * period_s), 14)).astype(int))
    out = np.zeros((len(t), 3))
    for line in lines:
        w, phase, a = 2 * np.pi * line / period_s, rng.uniform(0, 2 * np.pi), rng.uniform(0.4, 1.0) / line**1.1
        out += a * np.stack([np.sin(w * t + phase), w * np.cos(w * t + phase), -w * w * np.sin(w * t + phase)], axis=1)
    scale = min(fast / np.abs(out[:, 1]).max(), travel / np.abs(out[:, 0]).max())
    return out * scale


def points(t: Array, rng: Generator, fast: float, travel: float) -> Array:
    """Random moves and rests between random points."""
    times, values = [0.0, 0.7], [0.0, 0.0]
    while times[-1] < t[-1]:
        goal = rng.uniform(-travel, travel) if rng.random() < 0.85 else values[-1]
        times.append(times[-1] + max(0.5, abs(goal - values[-1]) * 1.9 / (fast * rng.uniform(0.25, 1.0))))
        values.append(goal)
    return smooth_points(t, np.array(times), np.array(values))


def few(t: Array, rng: Generator, fast: float, travel: float) -> Array:
    """Three or four slow moves one way and back, with long rests: what one records who does not know better."""
    moves = int(rng.integers(3, 5))
    times, values = [0.0, 0.7], [0.0, 0.0]
    for k in range(moves):
        goal = float(rng.uniform(0.3, 1.0) * travel * (1 if k % 2 == 0 else -1))
        times.append(times[-1] + max((t[-1] - 1.0) / moves * 0.7, abs(goal - values[-1]) * 1.9 / fast))
        values.append(goal)
        times.append(times[-1] + (t[-1] - 1.0) / moves * 0.3)
        values.append(goal)
    return smooth_points(t, np.array([*times, times[-1] + t[-1]]), np.array([*values, values[-1]]))


def start_at_rest(t: Array, reference: Array) -> Array:
    """Fade a reference in over 1.5 s from its value at t = 0."""
    s = np.clip(t / 1.5, 0.0, 1.0)
    g, d = 10 * s**3 - 15 * s**4 + 6 * s**5, (30 * s**2 - 60 * s**3 + 30 * s**4) / 1.5 * (t < 1.5)
    q = reference[:, 0] - reference[0, 0]
    position = q * g
    rate = reference[:, 1] * g + q * d
    return np.stack([position, rate, np.gradient(rate, t[1] - t[0])], axis=1)


def reference(
    kind: str, t: Array, rng: Generator, fast: float, travel: float, centre: float, top_hz: float, period_s: float
) -> Array:
    """One axis' reference of the named kind about `centre`, (n, 3)."""
    if kind == "plateaus":
        out = plateaus(t, rng, fast, travel)
    elif kind == "points":
        out = points(t, rng, fast, travel)
    elif kind == "few":
        out = few(t, rng, fast, travel)
    elif kind == "multisine":
        out = start_at_rest(t, multisine(t, rng, fast, travel, top_hz, period_s))
    elif kind == "mixed":
        half = len(t) // 2
        first = plateaus(t[:half], rng, fast, travel)
        second = start_at_rest(t[: len(t) - half], multisine(t[: len(t) - half], rng, fast, travel, top_hz, period_s))
        second[:, 0] += first[-1, 0]
        out = np.concatenate([first, second])
    else:
        raise ValueError(kind)
    out = out.copy()
    out[:, 0] += centre
    return out


def base_motion(rng: Generator, moving: bool, tilted: bool) -> Array:
    """Rows roll, pitch, yaw: offset rad, amplitude rad, frequency Hz, phase rad."""
    rows = np.zeros((3, 4))
    if tilted:
        rows[:2, 0] = rng.uniform(-0.2, 0.2, 2)
    if moving:
        rows[:, 1] = rng.uniform(0.03, 0.15, 3)
        rows[:, 2] = rng.uniform(0.15, 0.9, 3)
        rows[:, 3] = rng.uniform(0, 2 * np.pi, 3)
    return rows
