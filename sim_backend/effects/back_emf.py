"""Back-EMF: a motor on a voltage (or a current loop out of voltage) loses torque in proportion to its rate."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects.axis_scale import AxisScale
from sim_backend.effects.effect import Domain, Effect, Hook, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import SearchProfile, one_knob
from sim_backend.effects.separating_runs import MEASURED_TORQUE

COEFFICIENT = 0


@compiled
def command_less_back_emf(
    P: np.ndarray, o: int, X: np.ndarray, s: int, K: np.ndarray, u: float, q: float, v: float
) -> float:
    """u - k v, N m: before the actuator's lag, which the winding's current has, and before its limit."""
    return u - P[o + COEFFICIENT] * v


def _search(scale: AxisScale) -> SearchProfile:
    """Like viscous friction, and never against the sign of a motor."""
    return one_knob("coefficient", 0.2 * scale.drag, 0.0)


EFFECT = Effect(
    name="back_emf",
    domain=Domain.DRIVE,
    hook=Hook.COMMAND,
    law=command_less_back_emf,
    parameters=(
        Parameter("coefficient", "N m s/rad", 0.0, 1e6, 0.0, "torque lost per joint rate", linear_unit="N s/m"),
    ),
    text="torque falls with the rate of the motor",
    equation="T = u - k v",
    source="Krause et al., Analysis of Electric Machinery, ch. 2",
    excited_by="constant speeds over a decade; told from viscous friction only by a measured torque",
    # the winding sees the delayed command and the rate of now
    rank=1,
    search=_search,
    acts_through=frozenset({Variable.RATE}),
    separated_by=(MEASURED_TORQUE,),
    # the command says what the drive was asked for: whether friction or the winding took the rest, only the current
    # shows
    same_by_command="viscous",
)
