"""What may be added to a hypothesis: every effect of the catalogue, on every axis that can have it, searched as the
effect says.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from gimbal_hil.knowledge.discrepancy.hypotheses.axis_scales import axis_scale
from gimbal_hil.knowledge.discrepancy.twin import Record
from sim_backend.effects import CATALOGUE, SearchProfile
from sim_backend.model import AntennaModel


@dataclass(frozen=True)
class Family(SearchProfile):
    """An effect on an axis, with the profile by which it is searched there."""

    effect: str = field(kw_only=True)
    axis: str = field(kw_only=True)
    #: not all of a small change of the command comes through it, as measured on the logs
    cuts_command: bool = field(default=False, kw_only=True)
    #: position at which the angle of a ripple stays where its order moves: the middle of the travel. About a zero that
    #: is many turns away, an order and a phase would be one number
    middle: float = field(default=0.0, kw_only=True)

    @property
    def label(self) -> tuple[str, str]:
        """(effect, axis)."""
        return self.effect, self.axis


def profiled(model: AntennaModel, axis: str, records: tuple[Record, ...]) -> list[Family]:
    """Every effect of the catalogue, plugged-in ones included, that this axis can have in this data, scaled to both."""
    scale = axis_scale(model, axis, records)
    middle = 0.5 * (scale.position_low + scale.position_high)
    profiles = ((name, effect.profile(scale)) for name, effect in CATALOGUE.items())
    return [
        Family(**vars(profile), effect=name, axis=axis, middle=middle)
        for name, profile in profiles
        if profile is not None
    ]
