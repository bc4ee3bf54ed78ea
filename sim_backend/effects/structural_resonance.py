"""Structural resonance: a share of the inertia hangs on a spring behind the driven side, where the sensors sit.

phi is the twist, hung side against driven side. Hung inertia J2 = share J, spring k = J2 w^2, damper c = 2 zeta J2 w,
with w the antiresonance: what the hung side swings at when the driven side is held. The driven side feels k phi + c
phi'; the twist obeys phi'' = -(k phi + c phi') / J2 - (inertial acceleration of the driven side). The same leapfrog as
the plant's.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects.axis_scale import AxisScale
from sim_backend.effects.effect import Domain, Effect, Hook, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import Knob, SearchProfile, Start
from sim_backend.effects.separating_runs import REVERSAL_SIZES, TORQUE_SWEEP
from sim_backend.layout import STEP_S

ANTIRESONANCE_FREQUENCY, DAMPING_RATIO, INERTIA_SHARE = range(3)
TWIST, TWIST_RATE, TWIST_ACCELERATION = range(3)


@compiled
def _spring_per_inertia(P: np.ndarray, o: int, X: np.ndarray, s: int, h: float) -> float:
    """(k phi + c phi') / J2 at the middle of the step, rad/s^2."""
    w = 2.0 * math.pi * P[o + ANTIRESONANCE_FREQUENCY]
    twist = X[s + TWIST] + 0.5 * h * X[s + TWIST_RATE]
    twist_rate = X[s + TWIST_RATE] + 0.5 * h * X[s + TWIST_ACCELERATION]
    return w * (w * twist + 2.0 * P[o + DAMPING_RATIO] * twist_rate)


@compiled
def driven_side(
    P: np.ndarray, o: int, X: np.ndarray, s: int, torque: float, inertia: float, bias: float
) -> tuple[float, float]:
    """Torque on the driven side (N m), and the inertia that hangs on the spring (kg m^2); `bias` is the carrier's own
    acceleration.
    """
    if P[o + INERTIA_SHARE] == 0.0:
        return torque, 0.0
    hung = P[o + INERTIA_SHARE] * inertia
    return torque + hung * (_spring_per_inertia(P, o, X, s, P[STEP_S]) + bias), hung


@compiled
def advance_twist(
    P: np.ndarray, o: int, X: np.ndarray, s: int, torque: float, inertia: float, acceleration: float, h: float
) -> None:
    """Twist after the step, given the inertial acceleration (rad/s^2) that the driven side had in it."""
    if P[o + INERTIA_SHARE] == 0.0:
        return
    a = -_spring_per_inertia(P, o, X, s, h) - acceleration
    X[s + TWIST] += h * (X[s + TWIST_RATE] + 0.5 * h * a)
    X[s + TWIST_RATE] += h * a
    X[s + TWIST_ACCELERATION] = a


def _search(scale: AxisScale) -> SearchProfile:
    """Antiresonances from 4 to 60 Hz, closer than a lightly damped one is wide; at each only the hung share is
    proportional.
    """
    knobs = (
        Knob(("antiresonance_frequency",), low=-49.0, high=100.0),
        # how long it rings is seen only where it rings freely; beyond a fifth of critical it has no peak to speak of
        Knob(("damping_ratio",), size=0.02, low=-0.5, high=9.0, nuisance=True, named_up_to_high=True),
        Knob(("inertia_share",), size=0.05, low=0.0, high=15.0),
    )
    at = (float(hz) - 50.0 for hz in np.geomspace(4.0, 60.0, 20))
    return SearchProfile(knobs, tuple(Start(((x, 0.75, 0.4),), (x, 0.75, 0.0)) for x in at))


EFFECT = Effect(
    name="structural_resonance",
    domain=Domain.STRUCTURE,
    hook=Hook.STRUCTURE,
    law=driven_side,
    advance=advance_twist,
    states=3,
    parameters=(
        # the bounds keep the leapfrog stable at plant steps of 0.1 ms
        Parameter("antiresonance_frequency", "Hz", 0.5, 500.0, 50.0, "of the hung side with the driven side held"),
        Parameter("damping_ratio", "1", 0.0, 0.5, 0.01, "of the hung side with the driven side held"),
        Parameter("inertia_share", "1", 0.0, 0.8, 0.0, "share of the body's inertia that hangs on the spring"),
    ),
    text="a share of the inertia hangs on a spring",
    equation="J2 = share J, (J - J2) q'' = T + k phi + c phi', phi'' = -(k phi + c phi') / J2 - q''",
    source="Ellis, Control System Design Guide, ch. 16: two-inertia load",
    excited_by="chirp or pulses of torque through the resonance",
    # the motor's side of the chain (backlash) comes first
    rank=1,
    search=_search,
    acts_through=frozenset({Variable.TORQUE, Variable.ACCELERATION, Variable.PAST}),
    separated_by=(TORQUE_SWEEP, REVERSAL_SIZES),
    # tens of hertz on a leapfrog
    fine_steps=2,
    rings_on_encoder_noise=True,
)
