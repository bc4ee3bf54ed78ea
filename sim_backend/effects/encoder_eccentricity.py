"""Encoder eccentricity: a disc mounted off centre reads a once-per-turn error."""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import sine_cosine
from sim_backend.effects.axis_scale import AxisScale
from sim_backend.effects.effect import Domain, Effect, Hook, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import Knob, Reading, SearchProfile, Start
from sim_backend.effects.separating_runs import TWO_SPEEDS

AMPLITUDE, PHASE = range(2)


@compiled
def eccentric_reading(P: np.ndarray, o: int, X: np.ndarray, s: int, position: float) -> float:
    """e sin(q + phase), rad, added to the encoder's position."""
    return P[o + AMPLITUDE] * sine_cosine(position + P[o + PHASE])[0]


#: milliradians by which a fitted encoder can be off its centre
_MOST_ECCENTRIC = 25.0


def _search(scale: AxisScale) -> SearchProfile:
    """Amplitude and phase from both quarters: a milliradian is a tenth of a millimetre at a track of 100 mm."""
    knobs = (Knob(("amplitude",), size=1e-3, low=-_MOST_ECCENTRIC, high=_MOST_ECCENTRIC), Knob(("phase",)))
    return SearchProfile(knobs, (Start(((1.0, 0.0), (1.0, 0.5 * math.pi)), (0.0, 0.0), Reading.POLAR),))


EFFECT = Effect(
    name="encoder_eccentricity",
    domain=Domain.SENSOR,
    hook=Hook.ENCODER,
    law=eccentric_reading,
    parameters=(
        Parameter("amplitude", "rad", 0.0, 0.1, 0.0, "peak error: distance of the centres over the track's radius"),
        Parameter(
            "phase", "rad", -math.pi, math.pi, 0.0, "phase at zero position", periodic=True, half_turn_of="amplitude"
        ),
    ),
    text="once-per-turn error of the encoder",
    equation="position + e sin(q + phase)",
    source="Ellis, Control System Design Guide, ch. 14: encoders",
    excited_by="two constant speeds over a turn; gyro against encoder",
    rotary_only=True,
    search=_search,
    # a rate and an acceleration that are not there come with the position's error
    acts_through=frozenset({Variable.POSITION, Variable.RATE, Variable.ACCELERATION}),
    separated_by=(TWO_SPEEDS,),
)
