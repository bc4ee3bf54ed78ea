"""The run that best shows an unexplained residual, chosen by the variable on which the residual depends most."""

from __future__ import annotations

from gimbal_hil.knowledge.discrepancy.verdict.where import RegimeGroup
from sim_backend.effects import Variable

#: where no variable predicts what is left: the one that the regime with most of the gap speaks of
_OF_GROUP = {
    RegimeGroup.SPEED: Variable.RATE,
    RegimeGroup.DIRECTION: Variable.DIRECTION,
    RegimeGroup.EFFORT: Variable.ACCELERATION,
    RegimeGroup.REVERSAL: Variable.PAST,
    RegimeGroup.POSITION: Variable.POSITION,
    RegimeGroup.BASE: Variable.BASE_MOTION,
    RegimeGroup.TIME: Variable.TIME,
    RegimeGroup.TEMPERATURE: Variable.TEMPERATURE,
}
_RUNS = {
    Variable.DIRECTION: "the same way of {axis} both ways at a constant speed, three laps counted"
    " in a column named repeat",
    Variable.POSITION: "one slow turn of {axis} at two constant speeds, both ways, to search and to judge",
    Variable.RATE: "constant speeds of {axis} over a decade, both directions, three laps counted"
    " in a column named repeat",
    Variable.ACCELERATION: "the same speeds of {axis}, reached and left gently, and sharply",
    Variable.TORQUE: "the same motion of {axis} at two loads: a mass added, or against gravity and with it",
    Variable.TEMPERATURE: "the same motion of {axis} cold and warm",
    Variable.TIME: "the same motion of {axis} three times over, counted in a column named repeat",
    Variable.BASE_MOTION: "the same motion of {axis} on a base that stands, and on one that moves",
    Variable.OTHER_TORQUE: "the same motion of {axis} while the other axis stands, and while it is driven",
    Variable.ATTITUDE: "the same motion of {axis} with the base level, and with it tilted",
    Variable.PAST: "reversals of {axis} after short ways and after long ones, after a rest and without, three laps"
    " counted in a column named repeat",
}


def run_for(axis: str, depends_on: Variable | None, group: RegimeGroup) -> str:
    """What to do with an axis, given the variable that alone predicts what is left, if one does, and the regime in
    which most of it is.
    """
    return _RUNS[depends_on or _OF_GROUP[group]].format(axis=axis)
