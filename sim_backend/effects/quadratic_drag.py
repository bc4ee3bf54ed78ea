"""Quadratic drag: air (or churning) resistance that grows with the square of the rate."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects.axis_scale import AxisScale
from sim_backend.effects.effect import Domain, Effect, Hook, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import SearchProfile, one_knob
from sim_backend.effects.separating_runs import PLATEAUS

COEFFICIENT = 0


@compiled
def drag_torque(P: np.ndarray, o: int, X: np.ndarray, s: int, q: float, v: float, h: float) -> float:
    """-c v abs(v), N m."""
    return -P[o + COEFFICIENT] * v * abs(v)


def _search(scale: AxisScale) -> SearchProfile:
    """A fifth of the linear drag at the highest speed; air never pushes."""
    return one_knob("coefficient", 0.2 * scale.drag / scale.speed, 0.0)


EFFECT = Effect(
    name="quadratic_drag",
    domain=Domain.FRICTION,
    hook=Hook.TORQUE,
    law=drag_torque,
    parameters=(
        Parameter("coefficient", "N m s2/rad2", 0.0, 1e6, 0.0, "drag per squared rate", linear_unit="N s2/m2"),
    ),
    text="drag with the square of the rate",
    equation="F + c v abs(v)",
    source="Hoerner, Fluid-Dynamic Drag, ch. 1",
    excited_by="five or more constant speeds in both directions, the fastest as fast as allowed",
    search=_search,
    acts_through=frozenset({Variable.RATE}),
    separated_by=(PLATEAUS,),
)
