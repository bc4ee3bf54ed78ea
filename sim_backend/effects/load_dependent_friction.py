"""Load-dependent friction: bearing and gear friction that grows with the torque passed through them."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects.axis_scale import AxisScale, Need
from sim_backend.effects.effect import Domain, Effect, Hook, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import SearchProfile, one_knob
from sim_backend.effects.separating_runs import TWO_LOADS

COEFFICIENT = 0


@compiled
def loaded_levels(
    P: np.ndarray,
    o: int,
    X: np.ndarray,
    s: int,
    q: float,
    v: float,
    torque: float,
    temperature: float,
    ts: float,
    tc: float,
    sigma2: float,
) -> tuple[float, float, float]:
    """Ts and Tc plus c abs(T), N m, with T the applied torque."""
    load = P[o + COEFFICIENT] * abs(torque)
    return ts + load, tc + load, sigma2


def _search(scale: AxisScale) -> SearchProfile:
    """Bearings pass on a hundredth of their load as friction, gears a tenth; beyond 0.8 the joint would all but lock
    itself.
    """
    return one_knob("coefficient", 0.02, 0.0, 40.0)


EFFECT = Effect(
    name="load_dependent_friction",
    domain=Domain.FRICTION,
    hook=Hook.FRICTION,
    law=loaded_levels,
    # below 1: at 1 the joint would lock itself whatever the torque
    parameters=(Parameter("coefficient", "1", 0.0, 0.9, 0.0, "friction per applied torque"),),
    text="dry friction grows with the applied torque",
    equation="Tc, Ts + c abs(T)",
    source="Hamon et al., Dynamic identification of robots with load-dependent friction, IROS 2010",
    excited_by="the same motion at two loads: against and with gravity, or slow and fast reversals",
    # after the factors of asymmetry and position, which scale the unloaded friction
    rank=1,
    search=_search,
    needs=Need.SLIDING,
    acts_through=frozenset({Variable.TORQUE, Variable.RATE}),
    separated_by=(TWO_LOADS,),
)
