"""A joint by exact inverse dynamics, nothing of the product in it, and the text that a logger makes of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

COUNTS, FINE = 65536, 10
Swings = tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class Joint:
    """A joint and what logs it, SI: `swings` are amplitude, Hz and phase of sines by trajectory; a model believes its
    inertia, Coulomb level and viscous friction to be `believed` times what they are.
    """

    inertia: float
    coulomb: float
    viscous: float
    rate_hz: float
    step: float
    limit: float
    torque_constant: float
    torque_noise: float
    swings: Mapping[str, Swings]
    is_linear: bool = False
    believed: tuple[float, float, float] = (1.0, 0.8, 1.0)
    #: what a weight takes at a right angle, and the share of what it takes by which friction grows
    weight: float = 0.0
    under_load: float = 0.0

    def log(self, which: str = "a", seconds: float = 16.0, cogging: float = 0.0, seed: int = 1) -> JointLog:
        """A log of one trajectory that starts at rest; `cogging`, of seven waves a radian or metre, is what the model
        lacks.
        """
        rows = int(seconds * self.rate_hz)
        time = np.arange(rows) / self.rate_hz
        at = (np.arange(rows * FINE) + 0.5) / (self.rate_hz * FINE)
        q, v, a = _motion(self.swings[which], at)
        torque = self.inertia * a + self.coulomb * np.sign(v) + self.viscous * v + cogging * np.sin(7 * q + 0.4)
        load = self.weight * np.sin(q)
        torque += load + self.under_load * np.abs(load) * np.sign(v)
        q, v, _ = _motion(self.swings[which], time)
        noise = np.random.default_rng(seed).normal(0.0, self.torque_noise, rows)
        return JointLog(time, torque.reshape(rows, FINE).mean(axis=1) + noise, np.round(q / self.step) * self.step, v)

    def model_text(self) -> str:
        """The model file that a person would write of it."""
        inertia, coulomb, viscous = (
            share * number
            for share, number in zip(self.believed, (self.inertia, self.coulomb, self.viscous), strict=True)
        )
        body = f"{{mass: {inertia:.6g}}}" if self.is_linear else f"{{inertia: {{zz: {inertia:.6g}}}}}"
        return f"""\
schema: 1
name: mine
kind: {"linear" if self.is_linear else "rotary"}
axes:
  joint:
    body: {body}
    friction: {{coulomb: {coulomb:.6g}, breakaway: {1.07 * coulomb:.6g}, stribeck_velocity: 0.01, shape: 1.0,
               sigma0: {1070.0 * coulomb:.6g}, sigma1: {6.4275 * coulomb:.6g}, viscous: {viscous:.6g}}}
    actuator: {{limit: {self.limit}, torque_constant: {self.torque_constant}}}
    encoder: {{step: {self.step}}}
effects: []
"""


BENCH = Joint(
    *(0.02, 0.05, 0.02, 500.0, 2.0 * np.pi / COUNTS, 3.0, 1.8, 1e-3),
    swings={
        "a": ((0.9, 0.23, 0.0), (0.5, 0.71, 1.1), (0.25, 1.9, 2.3)),
        "b": ((1.1, 0.17, 0.6), (0.4, 0.83, 2.0), (0.2, 2.3, 0.3)),
    },
)
#: a mast of twelve kg m2 at 200 Hz
MAST = Joint(
    *(12.0, 6.0, 9.0, 200.0, 2.0 * np.pi / COUNTS, 150.0, 4.0, 0.05),
    swings={"a": ((1.2, 0.13, 0.0), (0.4, 0.41, 1.1), (0.1, 1.1, 2.3))},
    believed=(1.1, 0.85, 0.9),
)
#: a carriage of three kg on a linear axis at 1 kHz, m and N
CARRIAGE = Joint(
    *(3.0, 2.0, 8.0, 1000.0, 1e-6, 60.0, 12.0, 0.02),
    swings={"a": ((0.06, 0.3, 0.0), (0.03, 0.9, 1.1), (0.012, 2.1, 2.3))},
    is_linear=True,
    believed=(1.1, 0.85, 0.9),
)
#: what identification has to find of the bench, in its units
TRUE = {"inertia": BENCH.inertia, "coulomb": BENCH.coulomb, "viscous": BENCH.viscous, "offset": 0.0}
MODEL = BENCH.model_text()


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
    """A log of the bench; `cogging` N m is what its model lacks."""
    return BENCH.log(which, seconds, cogging, seed)


def _motion(swings: Swings, t: Floats) -> tuple[Floats, Floats, Floats]:
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
