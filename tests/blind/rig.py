"""The antennas of the bench as their models state them: the thesis' and a stranger's (heavy, light, slow, coarse, one
axis, ...).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np
from numpy.random import Generator

from tests.blind.causes import BODY, THESIS, Array

ENCODER_STEP = 2 * np.pi / 2**22


class Axes(Enum):
    """What moves."""

    GIMBAL = 0
    ROTARY = 1
    LINEAR = 2


@dataclass(frozen=True)
class Rig:
    """An antenna as its model states it, and how it is measured. Numbers are kept under "outer" and "inner", whatever
    their names.
    """

    axes: Axes = Axes.GIMBAL
    #: names in model and logs, outer first
    names: tuple[str, ...] = ("outer", "inner")
    friction: dict[str, dict[str, float]] = field(default_factory=lambda: {a: dict(THESIS[a]) for a in THESIS})
    bodies: dict[str, Array] = field(default_factory=lambda: {a: BODY[a].copy() for a in BODY})
    step_s: float = 1e-3
    encoder_step: float = ENCODER_STEP
    limits: tuple[float, float] = (15.5, 6.6)
    #: factor on what the loop and the torque noise are sized by
    heft: float = 1.0
    has_gyro: bool = True
    #: whether the model has a bristle; the antenna always has
    states_bristle: bool = True
    #: few reversals
    poor_motion: bool = False
    #: shares of the full length that the three logs have
    lengths: tuple[float, float, float] = (1.0, 1.0, 1.0)
    #: the shipped model's file as it is
    shipped: bool = False

    @property
    def inertia(self) -> Array:
        """What each axis accelerates about its own axis, kg m2 (kg)."""
        outer = self.bodies["outer"][9 if self.axes is Axes.LINEAR else 2]
        # the inner body and products of inertia come on top of the outer body's own moment
        if self.axes is Axes.GIMBAL:
            return np.array([outer + self.bodies["inner"][2], self.bodies["inner"][1]])
        return np.array([outer, 1.0])


STRANGERS = (
    "heavy",
    "light",
    "slow200",
    "slow500",
    "coarse",
    "nogyro",
    "rotary",
    "linear",
    "nobristle",
    "renamed",
    "poor",
    "uneven",
)


def _weighed(rig: Rig, heft: float) -> Rig:
    bodies = {a: b * np.where(np.isin(np.arange(10), (6, 7, 8)), 1.0, heft) for a, b in rig.bodies.items()}
    limits = rig.limits[0] * max(1.0, heft), rig.limits[1] * max(1.0, heft)
    return replace(rig, bodies=bodies, limits=limits, heft=heft)


def rig_named(name: str, rng: Generator) -> Rig:
    """A rig by its name: `thesis` (the shipped model), `plain` (its numbers in a file of their own) or one of
    STRANGERS.
    """
    rig = Rig()
    if name == "thesis":
        return replace(rig, shipped=True)
    if name == "heavy":
        return _weighed(rig, 5.0)
    if name == "light":
        return _weighed(rig, 0.2)
    if name in ("slow200", "slow500"):
        return replace(rig, step_s=1.0 / float(name[4:]))
    if name == "coarse":
        return replace(rig, encoder_step=2 * np.pi / 2**16)
    if name == "nogyro":
        return replace(rig, has_gyro=False)
    if name == "nobristle":
        return replace(rig, states_bristle=False)
    if name == "renamed":
        return replace(rig, names=("azimuth", "elevation"))
    if name == "poor":
        return replace(rig, poor_motion=True)
    if name == "uneven":
        return replace(rig, lengths=(1.0, float(rng.uniform(0.35, 0.6)), float(rng.uniform(0.5, 0.8))))
    if name == "rotary":
        return replace(rig, axes=Axes.ROTARY, names=("joint",), has_gyro=False)
    if name == "linear":
        return _linear(rng)
    if name == "plain":
        return rig
    raise ValueError(name)


def _linear(rng: Generator) -> Rig:
    """A slide of 5 to 100 kg whose friction weighs against its inertia as the antenna's does."""
    mass = float(np.exp(rng.uniform(np.log(5.0), np.log(100.0))))
    heft = mass / float(BODY["outer"][2])
    friction = {k: v * (heft if k in ("Ts", "Tc", "s0", "s1", "s2") else 1.0) for k, v in THESIS["outer"].items()}
    body = np.zeros(10)
    body[9] = mass
    return Rig(
        axes=Axes.LINEAR, names=("slide",), friction={"outer": friction, "inner": dict(THESIS["inner"])},
        bodies={"outer": body, "inner": BODY["inner"].copy()}, encoder_step=1e-6, limits=(15.5 * heft, 6.6), heft=heft,
        has_gyro=False,
    )  # fmt: skip
