"""Viscosity over temperature: grease that thins as it warms up."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import exponential
from sim_backend.effects.axis_scale import AxisScale, Need
from sim_backend.effects.effect import Domain, Effect, Hook, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import SearchProfile, one_knob
from sim_backend.effects.separating_runs import WARM_AND_COOL

TEMPERATURE_COEFFICIENT = 0
_REFERENCE_DEGC = 20.0


@compiled
def viscosity_at(
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
    """sigma2 exp(-b (temperature - 20 degC)), N m s/rad."""
    return ts, tc, sigma2 * exponential(-P[o + TEMPERATURE_COEFFICIENT] * (temperature - _REFERENCE_DEGC))


def _search(scale: AxisScale) -> SearchProfile:
    """Grease loses one to five per cent of its viscosity a kelvin."""
    return one_knob("temperature_coefficient", 0.01)


EFFECT = Effect(
    name="temperature_viscosity",
    domain=Domain.FRICTION,
    hook=Hook.FRICTION,
    law=viscosity_at,
    parameters=(
        Parameter("temperature_coefficient", "1/K", -0.2, 0.2, 0.0, "b, relative fall of viscosity per kelvin"),
    ),
    text="viscous friction falls as the joint warms up",
    equation="sigma2 exp(-b (temperature - 20 degC))",
    source="Bittencourt and Gunnarsson, Static friction in a robot joint, ASME JDSMC 134 (2012)",
    excited_by="constant speeds cold and warm; the temperature must move",
    search=_search,
    acts_through=frozenset({Variable.RATE, Variable.TEMPERATURE}),
    needs=Need.TEMPERATURE,
    separated_by=(WARM_AND_COOL,),
)
