"""Torque offset: the drive delivers torque at zero command."""

from __future__ import annotations

from sim_backend.effects.axis_scale import AxisScale
from sim_backend.effects.effect import Domain, Effect, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import SearchProfile, one_knob
from sim_backend.effects.separating_runs import FULL_TRAVEL, PLATEAUS, TWO_TILTS


def _search(scale: AxisScale) -> SearchProfile:
    """Five per cent of the torque that is commanded."""
    return one_knob("offset", 0.05 * scale.torque_rms)


EFFECT = Effect(
    name="torque_offset",
    domain=Domain.DRIVE,
    parameters=(Parameter("offset", "N m", -1e5, 1e5, 0.0, "o in T = u + o", linear_unit="N", path="actuator.offset"),),
    text="torque at zero command",
    equation="T = u + o",
    source="offset of the current sensor; SOURCE.md of the EMPS data shows a drifting one",
    excited_by="constant speeds in both directions at several positions",
    search=_search,
    # always there, and it may drift
    acts_through=frozenset({Variable.TIME}),
    separated_by=(PLATEAUS, FULL_TRAVEL, TWO_TILTS),
)
