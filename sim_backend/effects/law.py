"""Laws that a model file itself states (`kind: curve`), at the places where one may act.

They are effects without a name: no search of the catalogue knows them, and a law says what something looks like, not
what it is. What each is comes from its program (`law_program`).
"""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects.effect import Domain, Effect, Hook, Variable
from sim_backend.effects.law_program import law_value
from sim_backend.effects.parameter import Parameter
from sim_backend.layout import TEMPERATURE

#: of the friction that is there, a law leaves so much
_LEFT = 0.02
_AXIS = 2


@compiled
def _added_torque(P: np.ndarray, o: int, X: np.ndarray, s: int, q: float, v: float, h: float) -> float:
    """Torque at the joint, N m."""
    return law_value(P, o, X, s, q, v, 0.0, X[TEMPERATURE + int(P[o + _AXIS])])


@compiled
def _added_friction(
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
    """Levels of dry friction with what the law adds to both, N m; friction never drives."""
    more = law_value(P, o, X, s, q, v, torque, temperature)
    if more == 0.0:
        return ts, tc, sigma2
    return max(ts + more, _LEFT * ts), max(tc + more, _LEFT * tc), sigma2


@compiled
def _added_command(P: np.ndarray, o: int, X: np.ndarray, s: int, K: np.ndarray, u: float, q: float, v: float) -> float:
    """Commanded torque with what the law adds to it, N m."""
    return u + law_value(P, o, X, s, q, v, u, X[TEMPERATURE + int(P[o + _AXIS])])


@compiled
def _encoder_error(P: np.ndarray, o: int, X: np.ndarray, s: int, position: float) -> float:
    """What the encoder reads too much, rad."""
    return law_value(P, o, X, s, position, 0.0, 0.0, 0.0)


def _law(acts_on: str, hook: Hook, law: object, through: frozenset[Variable], unit: tuple[str, str]) -> Effect:
    return Effect(
        name=f"law of {acts_on}",
        domain=Domain.SENSOR if hook is Hook.ENCODER else Domain.DRIVE,
        hook=hook,
        law=law,  # type: ignore[arg-type]
        parameters=(
            Parameter("program", "1", 0.0, 1e9, 0.0, "where its program begins"),
            Parameter("operations", "1", 0.0, 1e4, 0.0, "how many operations that has"),
            Parameter("axis", "1", 0.0, 1.0, 0.0, "which axis it acts on"),
        ),
        text=f"a law of the model file that acts on {acts_on}, {unit[0]}",
        equation="as the file states it",
        source="the model file",
        excited_by="motion over what it is written over",
        # after the effects of the catalogue: what it was fitted beside
        rank=9,
        acts_through=through,
    )


_MOTION = frozenset({Variable.POSITION, Variable.RATE, Variable.TEMPERATURE, Variable.TIME, Variable.PAST})
#: by what they act on
LAWS: dict[str, Effect] = {
    "torque": _law("torque", Hook.TORQUE, _added_torque, _MOTION, ("N m", "N")),
    "friction": _law("friction", Hook.FRICTION, _added_friction, _MOTION | {Variable.TORQUE}, ("N m", "N")),
    "command": _law("command", Hook.COMMAND, _added_command, _MOTION | {Variable.TORQUE}, ("N m", "N")),
    "encoder": _law("encoder", Hook.ENCODER, _encoder_error, frozenset({Variable.POSITION}), ("rad", "m")),
}
