"""Viscous asymmetry: friction per rate that depends on the direction of motion."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects.effect import Domain, Effect, Hook, Parameter

ASYMMETRY = 0


@compiled
def asymmetric_viscosity(
    P: np.ndarray, o: int, X: np.ndarray, s: int, q: float, v: float, torque: float, temperature: float, ts: float, tc: float, sigma2: float
) -> tuple[float, float, float]:
    """sigma2 times 1 + a sign v, N m s/rad."""
    if v == 0.0:
        return ts, tc, sigma2
    return ts, tc, sigma2 * (1.0 + P[o + ASYMMETRY] if v > 0.0 else 1.0 - P[o + ASYMMETRY])


EFFECT = Effect(
    name="viscous_asymmetry",
    domain=Domain.FRICTION,
    hook=Hook.FRICTION,
    law=asymmetric_viscosity,
    parameters=(Parameter("asymmetry", "1", -0.9, 0.9, 0.0, "share by which forward viscosity is larger"),),
    text="viscous friction differs by direction",
    equation="sigma2 times 1 + a sign v",
    source="CONTRACTS 6; direction-dependent model of the EMPS benchmark (Janot et al. 2019)",
    excited_by="five or more constant speeds in both directions",
)
