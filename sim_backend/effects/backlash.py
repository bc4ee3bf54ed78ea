"""Backlash: the motor's rotor drives the joint through a gap, and the sensors sit on the joint.

The rotor's inertia is additional to the joint's, unless the model's inertia already counts (a share of) it. psi is the
rotor's lead; inside the gap (abs(psi) < gap/2) nothing is passed on, outside it a stiff, damped contact pushes and
never pulls. Contact frequency and damping are those of the two inertias swinging against each other through it. A gap
without rotor inertia is crossed in no time and passes every torque on unchanged.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects.axis_scale import AxisScale, Need
from sim_backend.effects.effect import Domain, Effect, Hook, PlainerEffect, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import Knob, Move, SearchProfile, point
from sim_backend.effects.separating_runs import REVERSAL_SIZES
from sim_backend.layout import STEP_S

GAP, ROTOR_INERTIA, COUNTED_SHARE, CONTACT_FREQUENCY, CONTACT_DAMPING = range(5)
LEAD, LEAD_RATE, LEAD_ACCELERATION, MOTOR_TORQUE, CONTACT_TORQUE = range(5)
#: what is left of the joint's inertia at least, however much of it is said to be the rotor's
_LEFT = 0.2


@compiled
def torque_through_gap(
    P: np.ndarray, o: int, X: np.ndarray, s: int, torque: float, inertia: float, bias: float
) -> tuple[float, float]:
    """Torque (N m) that the contact passes on to the joint during this step, and the inertia that is the rotor's (kg
    m^2).
    """
    rotor = P[o + ROTOR_INERTIA]
    if rotor == 0.0:
        return torque, 0.0
    h = P[STEP_S]
    counted = min(P[o + COUNTED_SHARE] * rotor, (1.0 - _LEFT) * inertia)
    left = inertia - counted
    reduced = rotor * left / (rotor + left)
    lead = X[s + LEAD] + 0.5 * h * X[s + LEAD_RATE]
    lead_rate = X[s + LEAD_RATE] + 0.5 * h * X[s + LEAD_ACCELERATION]
    half = 0.5 * P[o + GAP]
    into = lead - half if lead > half else (lead + half if lead < -half else 0.0)
    contact = 0.0
    if into != 0.0:
        w = 2.0 * math.pi * P[o + CONTACT_FREQUENCY]
        contact = reduced * w * (w * into + 2.0 * P[o + CONTACT_DAMPING] * lead_rate)
        # teeth push; without a gap the two flanks together also hold
        if half > 0.0:
            contact = max(0.0, contact) if into > 0.0 else min(0.0, contact)
    X[s + MOTOR_TORQUE], X[s + CONTACT_TORQUE] = torque, contact
    return contact + counted * bias, counted


@compiled
def advance_rotor(
    P: np.ndarray, o: int, X: np.ndarray, s: int, torque: float, inertia: float, acceleration: float, h: float
) -> None:
    """The rotor's lead after the step, given the joint's inertial acceleration (rad/s^2) in it."""
    rotor = P[o + ROTOR_INERTIA]
    if rotor == 0.0:
        return
    a = (X[s + MOTOR_TORQUE] - X[s + CONTACT_TORQUE]) / rotor - acceleration
    X[s + LEAD] += h * (X[s + LEAD_RATE] + 0.5 * h * a)
    X[s + LEAD_RATE] += h * a
    X[s + LEAD_ACCELERATION] = a


def _search(scale: AxisScale) -> SearchProfile:
    """Gaps of half a milliradian to eight, with rotors that the model's inertia counts already and rotors that come on
    top of it.
    """
    inertia = scale.own_inertia
    knobs = (
        # a degree is a hobby servo's; a wider gap, with next to no rotor, is hysteresis by another name
        Knob(("gap",), Move.LEVEL, 1e-3, -5.0, math.log(20.0)),
        Knob(("rotor_inertia",), Move.LEVEL, 0.2 * inertia, -7.0, 2.0),
        # what the model counts as the joint's may have been the rotor's; a joint with more inertia is another cause
        Knob((), size=0.05 * inertia, low=-19.0, high=1.0, along="body.own_inertia"),
        # how it bounces decides when the next flank is met; bounds keep the contact stable in the twin's steps
        Knob(("contact_frequency",), Move.LEVEL, 90.0, -1.2, 0.8, nuisance=True),
        Knob(("contact_damping",), Move.LEVEL, 0.3, -2.0, 1.0, nuisance=True),
    )
    rotors = ((0.08, 1.0), (0.25, 1.0), (0.001, 0.0), (0.01, 0.0), (0.08, 0.0))
    starts = tuple(
        point(math.log(gap / 1e-3), math.log(share / 0.2), -counted * share / 0.05, 0.0, 0.0)
        for gap in (5e-4, 2e-3, 8e-3)
        for share, counted in rotors
    )
    return SearchProfile(knobs, starts)


EFFECT = Effect(
    name="backlash",
    domain=Domain.STRUCTURE,
    hook=Hook.STRUCTURE,
    law=torque_through_gap,
    advance=advance_rotor,
    states=5,
    parameters=(
        Parameter("gap", "rad", 0.0, 0.5, 0.0, "whole width of the gap at the joint", linear_unit="m"),
        Parameter(
            "rotor_inertia",
            "kg m2",
            0.0,
            1e4,
            0.0,
            "of the rotor seen at the joint, beside the joint's own",
            linear_unit="kg",
        ),
        Parameter(
            "counted_share", "1", 0.0, 1.0, 0.0, "share of the rotor's inertia that the model's inertia already counts"
        ),
        # the bounds keep the contact stable at plant steps of 0.1 ms
        Parameter(
            "contact_frequency", "Hz", 10.0, 500.0, 90.0, "of rotor and joint against each other through the teeth"
        ),
        Parameter(
            "contact_damping", "1", 0.0, 1.0, 0.3, "damping ratio of the contact; 0.3 leaves a restitution of about 0.4"
        ),
    ),
    text="the rotor drives the joint through a gap",
    equation="Jr (q + psi)'' = T - Tc(psi), J q'' = Tc - F, Tc = 0 for abs(psi) < gap/2",
    source="Nordin and Gutman, Controlling mechanical systems with backlash, Automatica 38 (2002)",
    excited_by="torque reversals of several sizes",
    search=_search,
    acts_through=frozenset({Variable.TORQUE, Variable.ACCELERATION, Variable.PAST}),
    needs=Need.TORQUE_REVERSALS,
    separated_by=(REVERSAL_SIZES,),
    # a rotor whose gap leaves no trace is more inertia
    plainer=PlainerEffect("inertia"),
    # the contact swings at tens of hertz and closes within a fraction of a sample
    fine_steps=5,
)
