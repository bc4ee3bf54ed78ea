"""Whether the torque columns of logs are early or late against their positions, whatever the model lacks otherwise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.identification.axis_motion import regression_rule
from gimbal_hil.knowledge.identification.estimate import DataWarning
from gimbal_hil.knowledge.identification.rigid_axis import fit_rigid_axis
from gimbal_hil.knowledge.identification.rigid_load import axis_load
from gimbal_hil.knowledge.identification.timing import Timing
from sim_backend.effects import Hook
from sim_backend.model import AntennaModel

#: a minute of a log says enough of its clocks
_ENOUGH_S = 60.0
#: what looks the same: nothing acts before its command, but a drive may act late
_ELSE = {
    True: "no drive acts before its command, so it is the log; state it",
    False: "a delay of the drive looks the same; if it is the log, state it",
}


def shifted_torques(
    model: AntennaModel, tables: Sequence[SignalsTable], stated: frozenset[str] = frozenset()
) -> tuple[DataWarning, ...]:
    """A finding for each axis whose torque column the data exclude to be in time with its positions, from the longest
    log; none for axes whose times were `stated` or whose torque an effect of the model changes on its way, or where a
    log is too short to tell.
    """
    if not tables:
        return ()
    table = max(tables, key=len)
    table = table.rows(0, min(len(table), int(_ENOUGH_S / table.period_s)))
    found = []
    own = {entry.axis for entry in model.effects if entry.effect.hook in (Hook.COMMAND, Hook.STRUCTURE)}
    for axis in model.axes:
        timing = None if axis in stated or axis in own else _timing(model, table, axis)
        if timing is not None and timing.excludes_zero:
            text = f"{timing.text}: {_ELSE[timing.late_s > 0.0]}, as {timing.stated_by(axis)}"
            found.append(DataWarning("torque_shifted", text, axis))
    return tuple(found)


def _timing(model: AntennaModel, table: SignalsTable, axis: str) -> Timing | None:
    position = table.position(axis)
    if np.ptp(position) <= 100.0 * model.number(axis, "encoder.step"):
        return None
    load = axis_load(table, model, axis)
    try:
        rule = regression_rule(table.period_s)
        return fit_rigid_axis(table.time_s, position, load.held, rule, known=load.bias).timing
    except BadInputError:
        return None
