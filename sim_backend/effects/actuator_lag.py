"""Actuator lag: torque follows its command with a first-order delay."""

from __future__ import annotations

from sim_backend.effects.axis_scale import AxisScale
from sim_backend.effects.effect import Domain, Effect, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import SearchProfile, one_knob
from sim_backend.effects.separating_runs import REVERSAL_SIZES, TORQUE_SWEEP


def _search(scale: AxisScale) -> SearchProfile:
    """Half a millisecond to three: within a few samples its response is proportional to it, beyond 0.2 s nothing would
    be in control.
    """
    return one_knob("time_constant", 1e-3, 0.0, 200.0, (0.5, 3.0))


EFFECT = Effect(
    name="actuator_lag",
    domain=Domain.TIMING,
    parameters=(
        Parameter(
            "time_constant", "s", 0.0, 1.0, 0.0, "of the first-order lag; 0 means none", path="actuator.time_constant"
        ),
    ),
    text="first-order lag of the torque",
    equation="tau T' + T = u",
    source="current loop of the drive, closed-loop bandwidth 1/tau",
    excited_by="chirp or pulses of torque beyond 1/(10 tau)",
    search=_search,
    acts_through=frozenset({Variable.TORQUE, Variable.PAST}),
    separated_by=(TORQUE_SWEEP, REVERSAL_SIZES),
)
