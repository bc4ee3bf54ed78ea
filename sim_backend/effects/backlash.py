"""Backlash: the motor's rotor drives the joint through a gap, and the sensors sit on the joint.

The rotor's inertia is additional to the joint's. psi is the rotor's lead; inside the gap (abs(psi) < gap/2) nothing is passed
on, outside it a stiff, damped contact pushes and never pulls. The contact's stiffness comes from the contact frequency of the two
inertias, far above any loop. A gap without rotor inertia is crossed in no time and passes every torque on unchanged.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects.effect import Domain, Effect, Hook, Parameter
from sim_backend.layout import STEP_S

GAP, ROTOR_INERTIA = range(2)
LEAD, LEAD_RATE, LEAD_ACCELERATION, MOTOR_TORQUE, CONTACT_TORQUE = range(5)
#: both inertias against the contact: a hard gear tooth, and yet 40 plant steps of 0.1 ms a swing
_CONTACT_RAD_S = 2.0 * math.pi * 250.0
#: leaves a restitution of about 0.4
_CONTACT_DAMPING = 0.3


@compiled
def torque_through_gap(P: np.ndarray, o: int, X: np.ndarray, s: int, torque: float, inertia: float, bias: float) -> tuple[float, float]:
    """Torque (N m) that the contact passes on to the joint during this step; no inertia is taken off."""
    rotor = P[o + ROTOR_INERTIA]
    if rotor == 0.0:
        return torque, 0.0
    h = P[STEP_S]
    reduced = rotor * inertia / (rotor + inertia)
    lead = X[s + LEAD] + 0.5 * h * X[s + LEAD_RATE]
    lead_rate = X[s + LEAD_RATE] + 0.5 * h * X[s + LEAD_ACCELERATION]
    half = 0.5 * P[o + GAP]
    into = lead - half if lead > half else (lead + half if lead < -half else 0.0)
    contact = 0.0
    if into != 0.0:
        contact = reduced * _CONTACT_RAD_S * (_CONTACT_RAD_S * into + 2.0 * _CONTACT_DAMPING * lead_rate)
        # teeth push; without a gap the two flanks together also hold
        if half > 0.0:
            contact = max(0.0, contact) if into > 0.0 else min(0.0, contact)
    X[s + MOTOR_TORQUE], X[s + CONTACT_TORQUE] = torque, contact
    return contact, 0.0


@compiled
def advance_rotor(P: np.ndarray, o: int, X: np.ndarray, s: int, torque: float, inertia: float, acceleration: float, h: float) -> None:
    """The rotor's lead after the step, given the joint's inertial acceleration (rad/s^2) in it."""
    rotor = P[o + ROTOR_INERTIA]
    if rotor == 0.0:
        return
    a = (X[s + MOTOR_TORQUE] - X[s + CONTACT_TORQUE]) / rotor - acceleration
    X[s + LEAD] += h * (X[s + LEAD_RATE] + 0.5 * h * a)
    X[s + LEAD_RATE] += h * a
    X[s + LEAD_ACCELERATION] = a


EFFECT = Effect(
    name="backlash",
    domain=Domain.STRUCTURE,
    hook=Hook.STRUCTURE,
    law=torque_through_gap,
    advance=advance_rotor,
    states=5,
    parameters=(
        Parameter("gap", "rad", 0.0, 0.5, 0.0, "whole width of the gap at the joint", linear_unit="m"),
        Parameter("rotor_inertia", "kg m2", 0.0, 1e4, 0.0, "of the rotor seen at the joint, beside the joint's own", linear_unit="kg"),
    ),
    text="the rotor drives the joint through a gap",
    equation="Jr (q + psi)'' = T - Tc(psi), J q'' = Tc - F, Tc = 0 for abs(psi) < gap/2",
    source="CONTRACTS 6; Nordin and Gutman, Controlling mechanical systems with backlash, Automatica 38 (2002)",
    excited_by="torque reversals of several sizes",
)
