"""Coulomb asymmetry: dry friction that depends on the direction of motion."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects.axis_scale import AxisScale, Need
from sim_backend.effects.effect import Domain, Effect, Hook, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import SearchProfile, one_knob
from sim_backend.effects.separating_runs import PLATEAUS

ASYMMETRY = 0


@compiled
def asymmetric_levels(
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
    """Ts and Tc times 1 + a sign v, N m."""
    if v == 0.0:
        return ts, tc, sigma2
    factor = 1.0 + P[o + ASYMMETRY] if v > 0.0 else 1.0 - P[o + ASYMMETRY]
    return ts * factor, tc * factor, sigma2


def _search(scale: AxisScale) -> SearchProfile:
    """Five per cent of the friction by direction is what careful runs show."""
    return one_knob("asymmetry", 0.05)


EFFECT = Effect(
    name="coulomb_asymmetry",
    domain=Domain.FRICTION,
    hook=Hook.FRICTION,
    law=asymmetric_levels,
    parameters=(Parameter("asymmetry", "1", -0.9, 0.9, 0.0, "share by which forward friction is larger"),),
    text="dry friction differs by direction",
    equation="Tc, Ts times 1 + a sign v",
    source="Armstrong-Helouvry et al., Automatica 30 (1994)",
    excited_by="several constant speeds in both directions",
    search=_search,
    needs=Need.SLIDING,
    acts_through=frozenset({Variable.RATE}),
    separated_by=(PLATEAUS,),
)
