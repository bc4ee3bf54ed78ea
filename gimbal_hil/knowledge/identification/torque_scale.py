"""Whether anything in a log says how large its torque is: without a known weight or inertia nothing does.

Inertia, friction and offset are all proportional to the torque column. A current in peak for rms, another torque
constant or a forgotten gear make all of them wrong by one factor, in intervals as narrow as ever.
"""

from __future__ import annotations

import numpy as np

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.identification.estimate import DataWarning, Determination, Estimate, withheld
from gimbal_hil.knowledge.identification.rigid_load import AxisLoad
from sim_backend.model import AntennaModel

#: a known torque of this share of the whole says how large that is
_SAYS_IT = 0.1
#: an inertia within this share of the model's vouches for the torque: both would have to be off alike
_SAME = 0.1
_TURN = 2.0 * np.pi
#: rule of the finding that positions are in turns
IN_TURNS = "position_in_turns"


def scale_findings(
    load: AxisLoad, table: SignalsTable, model: AntennaModel, axis: str, estimates: tuple[Estimate, ...]
) -> tuple[DataWarning, ...]:
    """What a reader must know of the scale of a log's torque; nothing where a torque that is known tells it."""
    known = load.bias - np.mean(load.bias)
    given = table.signal(axis, "torque_known")
    if given is not None:
        known = known + given - np.mean(given)
    told = {e.name: e for e in estimates if e.verdict is Determination.IDENTIFIED and e.name != "offset"}
    if not told or np.std(known) >= _SAYS_IT * np.std(load.held):
        return ()
    inertia, own = told.get("inertia"), model.number(axis, model.own_inertia_path(axis))
    text = (
        f"nothing in this log says how large its torque is: {_and(list(told))} would be wrong by the "
        "factor that the torque column is wrong by (a current in peak for rms, another torque constant, a gear)"
    )
    if inertia is not None and own > 0.0:
        times = inertia.value / own
        if abs(times - 1.0) <= _SAME:
            return ()
        if not model.is_linear and abs(times / _TURN - 1.0) <= _SAME:
            turns = (
                f"the inertia is {times:.3g} times the model's {own:.4g}, about 2 pi: the position seems to be in "
                f"turns, as ODrive and moteus log it, and is read in radians: --column {axis}.position=COLUMN:turn"
            )
            return (DataWarning(IN_TURNS, turns, axis, frozenset(e.name for e in told.values() if _has_angle(e))),)
        text += f". The inertia is {times:.3g} times the model's {own:.4g}: if that one is known, this is the factor"
    return (DataWarning("torque_scale", text, axis, frozenset(told)),)


def without_doubted(estimates: tuple[Estimate, ...], findings: tuple[DataWarning, ...]) -> tuple[Estimate, ...]:
    """The estimates without those that a position in turns would have made wrong: of them the prior stays."""
    if not any(one.rule == IN_TURNS for one in findings):
        return estimates
    reason = "the position seems to be in turns, and this number depends on its unit"
    experiment = "the same log, with the unit of its position stated"
    return tuple(
        withheld(one.name, one.unit, one.prior, reason, experiment)
        if _has_angle(one) and one.verdict is not Determination.NOT_IDENTIFIED
        else one
        for one in estimates
    )


def _has_angle(estimate: Estimate) -> bool:
    """Whether the number changes with the unit of the position."""
    return "rad" in estimate.unit or estimate.name == "inertia"


def _and(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
