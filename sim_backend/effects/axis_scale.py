"""What a search profile is scaled by: one axis of a model and of its data in plain numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Flag, auto

#: shares of the samples below which `AxisScale.torque_levels` lie
TORQUE_SHARES = (0.9, 0.96, 0.985, 0.994, 0.998, 0.9995)
#: as far as joints give way before they slide, at most, and mostly: rad, m
GIVES_RAD, GIVES_M = 0.02, 1e-3
SLIDES_RAD, SLIDES_M = 2e-3, 1e-4
#: rad/s, m/s: slower than this a joint may hang on its bristle, so that a model without one does not state its friction
CREEPS_RAD_S, CREEPS_M_S = 4e-3, 2e-4
#: friction and drag of a model that states none, as a share of the torque that is commanded
_LEAST_SHARE = 0.02


class Need(Flag):
    """What data must have for an effect to show."""

    NOTHING = 0
    #: a gyro on this axis: without it there is no signal that the effect could show in
    GYRO = auto()
    #: a base that turns
    MOVING_BASE = auto()
    #: a temperature column that moves
    TEMPERATURE = auto()
    #: torque of both signs
    TORQUE_REVERSALS = auto()
    #: another axis that moves
    SECOND_AXIS = auto()
    #: a joint that slides, or all but: it goes further than joints mostly give way, or is pushed beyond half of its
    #: break-away, where its bristles bend by what the level is
    SLIDING = auto()

    @property
    def text(self) -> str:
        """One need in words."""
        return str(self.name).lower().replace("_", " ")


@dataclass(frozen=True)
class AxisScale:
    """One axis in the units of its kind (rad, N m or m, N): sizes from the data, numbers from the model. No records, no
    model.
    """

    #: of the commanded torque; 1 where nothing was commanded
    torque_rms: float
    torque_peak: float
    #: the commanded torque's modulus below which the shares TORQUE_SHARES of the samples lie
    torque_levels: tuple[float, ...]
    #: joint rate that is hardly ever exceeded (98 % of the samples)
    speed: float
    position_low: float
    position_high: float
    #: every number of the axis by its path in the model file, and its moment about its own axis (mass) as
    #: "body.own_inertia"
    numbers: Mapping[str, float]
    is_linear: bool
    axis_count: int
    axis_index: int
    #: what the data of this axis has
    present: Need
    #: what the model states of added physics, by (effect, parameter)
    stated: Mapping[tuple[str, str], float] = field(default_factory=dict)

    @property
    def travel(self) -> float:
        """From the lowest to the highest position."""
        return self.position_high - self.position_low

    @property
    def least_stated_speed(self) -> float:
        """Speed below which the model does not say what friction is; 0 where it states a bristle."""
        if self.numbers["friction.sigma0"] > 0.0:
            return 0.0
        return CREEPS_M_S if self.is_linear else CREEPS_RAD_S

    @property
    def own_inertia(self) -> float:
        """Moment about the joint's own axis, kg m^2 (mass, kg)."""
        return self.numbers["body.own_inertia"]

    @property
    def cog_distance(self) -> float:
        """From the pivot to the body's centre of gravity, m."""
        return float(sum(self.numbers[f"body.cog.{c}"] ** 2 for c in "xyz") ** 0.5)

    @property
    def friction(self) -> float:
        """Dry friction to count in: the model's Coulomb level, or a share of the torque where it states next to
        none.
        """
        return max(self.numbers["friction.coulomb"], _LEAST_SHARE * self.torque_rms)

    @property
    def drag(self) -> float:
        """Friction per rate to count in: the model's viscosity, or a share of the torque at speed."""
        return max(self.numbers["friction.viscous"], _LEAST_SHARE * self.torque_rms / self.speed)
