"""A joint by exact inverse dynamics, nothing of the product in it, and the text that a logger makes of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

RATE_HZ, COUNTS, TORQUE_NOISE, FINE = 500.0, 65536, 1e-3, 10
#: what identification has to find, in its units
TRUE = {"inertia": 0.02, "coulomb": 0.05, "viscous": 0.02, "offset": 0.0}
MODEL = """\
schema: 1
name: mine
kind: rotary
axes:
  joint:
    body: {inertia: {zz: 0.02}}
    friction: {coulomb: 0.04, breakaway: 0.0428, stribeck_velocity: 0.01, shape: 1.0, sigma0: 42.8, sigma1: 0.2571,
               viscous: 0.02}
    actuator: {limit: 3.0, torque_constant: 1.8}
    encoder: {step: 9.587379924285257e-05}
effects: []
"""
_SWINGS = {
    "a": ((0.9, 0.23, 0.0), (0.5, 0.71, 1.1), (0.25, 1.9, 2.3)),
    "b": ((1.1, 0.17, 0.6), (0.4, 0.83, 2.0), (0.2, 2.3, 0.3)),
}


@dataclass(frozen=True)
class JointLog:
    """Rows of a log, (n,) each: seconds, N m (held from its row to the next), rad, rad/s."""

    time: Floats
    torque: Floats
    position: Floats
    rate: Floats

    def but(self, **changed: Floats) -> JointLog:
        """The same with other columns."""
        return replace(self, **changed)

    def text(self, **form: object) -> str:
        """As a table that every column names itself."""
        columns = {"time_s": self.time, "joint.torque": self.torque, "joint.position": self.position}
        return table_text(columns, **form)  # type: ignore[arg-type]


def swinging(which: str = "a", seconds: float = 16.0, cogging: float = 0.0, seed: int = 1) -> JointLog:
    """A log of one trajectory that starts at rest; `cogging` N m of seven waves a turn is what the model lacks."""
    rows = int(seconds * RATE_HZ)
    time = np.arange(rows) / RATE_HZ
    at = (np.arange(rows * FINE) + 0.5) / (RATE_HZ * FINE)
    q, v, a = _motion(_SWINGS[which], at)
    torque = TRUE["inertia"] * a + TRUE["coulomb"] * np.sign(v) + TRUE["viscous"] * v + cogging * np.sin(7 * q + 0.4)
    q, v, _ = _motion(_SWINGS[which], time)
    step = 2.0 * np.pi / COUNTS
    noise = np.random.default_rng(seed).normal(0.0, TORQUE_NOISE, rows)
    return JointLog(time, torque.reshape(rows, FINE).mean(axis=1) + noise, np.round(q / step) * step, v)


def _motion(swings: tuple[tuple[float, float, float], ...], t: Floats) -> tuple[Floats, Floats, Floats]:
    q, v, a = np.zeros_like(t), np.zeros_like(t), np.zeros_like(t)
    for size, hertz, phase in swings:
        w = 2.0 * np.pi * hertz
        q += size * (np.sin(w * t + phase) - np.sin(phase))
        v += size * w * np.cos(w * t + phase)
        a -= size * w * w * np.sin(w * t + phase)
    x = np.clip(t, 0.0, 1.0)
    s, ds, dds = x**3 * (10 - 15 * x + 6 * x * x), 30 * x**2 * (1 - x) ** 2, 60 * x - 180 * x**2 + 120 * x**3
    return s * q, ds * q + s * v, dds * q + 2.0 * ds * v + s * a


def table_text(
    columns: Mapping[str, Floats],
    between: str = ",",
    forms: Mapping[str, Callable[[float], str] | str] | None = None,
    end: str = "\n",
) -> str:
    """A header and a line a row; `forms` say how a column's numbers are written."""
    given = {"time_s": ".3f", **(forms or {})}

    def cell(name: str, value: float) -> str:
        form = given.get(name, ".9g")
        return format(value, form) if isinstance(form, str) else form(value)

    lines = [between.join(columns)]
    lines += [between.join(map(cell, columns, row)) for row in zip(*columns.values(), strict=True)]
    return end.join(lines) + end
