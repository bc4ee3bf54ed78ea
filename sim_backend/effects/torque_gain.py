"""Torque gain: the drive delivers more or less torque than commanded."""

from __future__ import annotations

from sim_backend.effects.axis_scale import AxisScale
from sim_backend.effects.effect import Domain, Effect, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import SearchProfile, one_knob
from sim_backend.effects.separating_runs import KNOWN_LOAD, PLATEAUS, REVERSAL_SIZES, TWO_LOADS


def _search(scale: AxisScale) -> SearchProfile:
    """A torque constant is five per cent off; a drive that gives less than a quarter of what it is asked for is broken,
    not scaled.
    """
    return one_knob("gain_error", 0.05, -15.0, 40.0)


EFFECT = Effect(
    name="torque_gain",
    domain=Domain.DRIVE,
    parameters=(Parameter("gain_error", "1", -0.9, 5.0, 0.0, "e in T = (1 + e) u", path="actuator.gain_error"),),
    text="torque constant or scale of the drive",
    equation="T = (1 + e) u",
    source="motor torque constant; Krause et al., Analysis of Electric Machinery, ch. 2",
    excited_by="a known load: gravity, added inertia, or a stall run",
    search=_search,
    acts_through=frozenset({Variable.TORQUE}),
    separated_by=(PLATEAUS, KNOWN_LOAD, REVERSAL_SIZES, TWO_LOADS),
    asked_as="torque gain",
    must_show=True,
)
