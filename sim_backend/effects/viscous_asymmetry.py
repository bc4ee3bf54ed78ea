"""Viscous asymmetry: friction per rate that depends on the direction of motion."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects.axis_scale import AxisScale
from sim_backend.effects.effect import Domain, Effect, Hook, RateForm, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import SearchProfile, one_knob
from sim_backend.effects.separating_runs import PLATEAUS

ASYMMETRY = 0


@compiled
def asymmetric_viscosity(
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
    """sigma2 times 1 + a sign v, N m s/rad."""
    if v == 0.0:
        return ts, tc, sigma2
    return ts, tc, sigma2 * (1.0 + P[o + ASYMMETRY] if v > 0.0 else 1.0 - P[o + ASYMMETRY])


def _search(scale: AxisScale) -> SearchProfile:
    """A tenth by direction; it can take no more than all."""
    return one_knob("asymmetry", 0.1)


EFFECT = Effect(
    name="viscous_asymmetry",
    domain=Domain.FRICTION,
    hook=Hook.FRICTION,
    law=asymmetric_viscosity,
    parameters=(Parameter("asymmetry", "1", -0.9, 0.9, 0.0, "share by which forward viscosity is larger"),),
    text="viscous friction differs by direction",
    equation="sigma2 times 1 + a sign v",
    source="direction-dependent model of the EMPS benchmark (Janot et al. 2019)",
    excited_by="five or more constant speeds in both directions",
    search=_search,
    acts_through=frozenset({Variable.RATE}),
    separated_by=(PLATEAUS,),
    # both are even in the rate: over the speeds of one log they may be the same curve twice
    forms=(RateForm("|v|", 1), RateForm("v^2", 2)),
)
