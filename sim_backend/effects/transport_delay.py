"""Transport delay: bus, drive and modulator apply a command a fixed time after it was given.

A ring holds the command of each plant step. A delay that is no whole number of steps takes the mean over the step of
the shifted command, so its impulse (torque times time) is exact; where in the step it acts is told by its first moment.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects.axis_scale import AxisScale
from sim_backend.effects.effect import Domain, Effect, Hook, Variable
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import SearchProfile, one_knob
from sim_backend.effects.separating_runs import REVERSAL_SIZES, TORQUE_SWEEP
from sim_backend.layout import COMMAND_MOMENT, STEP_S, STEPS

DELAY = 0
#: plant steps that the ring holds; longer delays are cut to it (204 ms at steps of 0.1 ms)
RING = 2048


@compiled
def delayed_command(P: np.ndarray, o: int, X: np.ndarray, s: int, K: np.ndarray, u: float, q: float, v: float) -> float:
    """Command (N m) that acts during this step: row k over [t_k + d, t_k+1 + d), zero before the first."""
    if P[o + DELAY] == 0.0:
        return u
    step = int(X[STEPS])
    X[s + step % RING] = u
    in_steps = min(P[o + DELAY] / P[STEP_S], RING - 2.0)
    whole = int(math.floor(in_steps))
    share = in_steps - whole
    now = X[s + (step - whole) % RING] if step >= whole else 0.0
    # a share of rounding (3 ms / 0.1 ms is not quite 30) must not mix in a neighbour
    if share < 1e-9:
        return now
    before = X[s + (step - whole - 1) % RING] if step > whole else 0.0
    X[COMMAND_MOMENT] = 0.5 * share * (1.0 - share) * (now - before)
    return now + share * (before - now)


def _search(scale: AxisScale) -> SearchProfile:
    """Half a millisecond to three: within a few samples its response is proportional to it."""
    return one_knob("delay", 1e-3, probes=(0.5, 3.0))


EFFECT = Effect(
    name="transport_delay",
    domain=Domain.TIMING,
    hook=Hook.COMMAND,
    law=delayed_command,
    states=RING,
    parameters=(
        Parameter(
            "delay", "s", 0.0, 0.05, 0.0, "time from a row of commanded torque to its effect; fractions of a tick count"
        ),
    ),
    text="torque acts later than commanded",
    equation="row k acts over [t_k + d, t_k+1 + d)",
    source="Franklin et al., Digital Control of Dynamic Systems, ch. 4",
    excited_by="chirp or pulses of torque; fast reversals",
    search=_search,
    acts_through=frozenset({Variable.TORQUE, Variable.PAST}),
    separated_by=(TORQUE_SWEEP, REVERSAL_SIZES),
)
