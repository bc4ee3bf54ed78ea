"""Encoder eccentricity: a disc mounted off centre reads a once-per-turn error."""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import sine_cosine
from sim_backend.effects.effect import Domain, Effect, Hook, Parameter

AMPLITUDE, PHASE = range(2)


@compiled
def eccentric_reading(P: np.ndarray, o: int, X: np.ndarray, s: int, position: float) -> float:
    """e sin(q + phase), rad, added to the encoder's position."""
    return P[o + AMPLITUDE] * sine_cosine(position + P[o + PHASE])[0]


EFFECT = Effect(
    name="encoder_eccentricity",
    domain=Domain.SENSOR,
    hook=Hook.ENCODER,
    law=eccentric_reading,
    parameters=(
        Parameter("amplitude", "rad", 0.0, 0.1, 0.0, "peak error: distance of the centres over the track's radius"),
        Parameter("phase", "rad", -math.pi, math.pi, 0.0, "phase at zero position", periodic=True),
    ),
    text="once-per-turn error of the encoder",
    equation="position + e sin(q + phase)",
    source="CONTRACTS 6; Ellis, Control System Design Guide, ch. 14: encoders",
    excited_by="two constant speeds over a turn; gyro against encoder",
    rotary_only=True,
)
