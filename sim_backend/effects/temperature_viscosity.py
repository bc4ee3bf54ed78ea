"""Viscosity over temperature: grease that thins as it warms up."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import exponential
from sim_backend.effects.effect import Domain, Effect, Hook, Parameter

TEMPERATURE_COEFFICIENT = 0
_REFERENCE_DEGC = 20.0


@compiled
def viscosity_at(
    P: np.ndarray, o: int, X: np.ndarray, s: int, q: float, v: float, torque: float, temperature: float, ts: float, tc: float, sigma2: float
) -> tuple[float, float, float]:
    """sigma2 exp(-b (temperature - 20 degC)), N m s/rad."""
    return ts, tc, sigma2 * exponential(-P[o + TEMPERATURE_COEFFICIENT] * (temperature - _REFERENCE_DEGC))


EFFECT = Effect(
    name="temperature_viscosity",
    domain=Domain.FRICTION,
    hook=Hook.FRICTION,
    law=viscosity_at,
    parameters=(Parameter("temperature_coefficient", "1/K", -0.2, 0.2, 0.0, "b, relative fall of viscosity per kelvin"),),
    text="viscous friction falls as the joint warms up",
    equation="sigma2 exp(-b (temperature - 20 degC))",
    source="CONTRACTS 6; Bittencourt and Gunnarsson, Static friction in a robot joint, ASME JDSMC 134 (2012)",
    excited_by="constant speeds cold and warm; the temperature must move",
)
