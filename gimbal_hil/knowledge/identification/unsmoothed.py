"""Logs whose columns somebody smoothed before they were saved, with the smoothing taken back for a search.

A regression can put a smoothing on what explains the torque. A search over effects cannot: it steps along the motion
that was measured. So it gets the columns as they were, as far as anything is left of them, and a band in which that is
most of it. Logs that are given together were saved by one person: one smoothing has to explain them all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.axis_motion import regression_rule
from gimbal_hil.knowledge.identification.rigid_axis import AsLogged, as_logged
from gimbal_hil.knowledge.identification.rigid_load import axis_load
from gimbal_hil.knowledge.identification.smoothed_log import SmoothedColumn, SmoothedLog
from sim_backend.model import AntennaModel

#: a minute of a log says enough of how it was saved
_ENOUGH_S = 60.0
#: an axis that moves by fewer steps of its encoder says nothing of how its columns were saved
_LEAST_STEPS = 100.0
#: a smoothing counts where this share of the squares is left, over all rows of all logs; with a cut-off that is only
#: near it may leave so much
_LEFT, _LEFT_PERHAPS = 0.5, 0.9
#: cut-offs below this share of the regression's band leave no motion to compare
_SLOWEST = 0.1
#: steps of a position are whole ones of its encoder to this share of one, in so many rows: nobody smoothed it
_WHOLE, _ALMOST_ALL = 0.05, 0.9
#: third differences of rounding to steps, in steps, and the share of them below which a position was smoothed
_THIRD_DIFFERENCES, _SMOOTHER, _MEDIAN_TO_SIGMA = np.sqrt(20.0 / 12.0), 0.25, 1.4826
_SIGNALS = {
    SmoothedColumn.TORQUE: ("torque",),
    SmoothedColumn.POSITION: ("position",),
    SmoothedColumn.BOTH: ("torque", "position"),
}


@dataclass(frozen=True)
class Unsmoothed:
    """Logs as they were before they were smoothed, or as they are; up to `to_hz` half or more of them was left, None
    where there is no such limit.
    """

    tables: tuple[SignalsTable, ...]
    to_hz: float | None = None


def unsmoothed(model: AntennaModel, tables: Sequence[SignalsTable]) -> Unsmoothed:
    """Logs with the smoothing of their torque and position columns taken back, which a note of each tells."""
    found = Unsmoothed(tuple(tables))
    for axis in model.axes:
        asked = {k: one for k, table in enumerate(tables) if (one := _asked(model, table, axis)) is not None}
        smoothing = _common(list(asked.values()), model.number(axis, "encoder.step"))
        if smoothing is not None:
            freed = (
                _taken_back(table, axis, smoothing) if k in asked else table for k, table in enumerate(found.tables)
            )
            ends = [smoothing.smoothing.half_hz, *([] if found.to_hz is None else [found.to_hz])]
            found = replace(found, tables=tuple(freed), to_hz=min(ends))
    return found


def _asked(model: AntennaModel, table: SignalsTable, axis: str) -> AsLogged | None:
    """The regression of an axis over the first minute of a log; None where it cannot tell anything."""
    table = table.rows(0, min(len(table), int(_ENOUGH_S / table.period_s)))
    position = table.position(axis)
    if np.ptp(position) <= _LEAST_STEPS * model.number(axis, "encoder.step"):
        return None
    load = axis_load(table, model, axis)
    try:
        return as_logged(table.time_s, position, load.held, regression_rule(table.period_s), load.bias)
    except BadInputError:
        return None


def _common(logs: Sequence[AsLogged], step: float) -> SmoothedLog | None:
    """The smoothing that leaves least of all logs together; None where none counts.

    What the regression of the longest log tells by itself, and of a position that is smoother than its encoder reads
    also what only all logs together tell.
    """
    if not logs:
        return None
    smoother = all(_is_smoother_than_read(one.motion.position, step) for one in logs)
    longest = max(logs, key=lambda one: len(one.motion.time_s))

    def share(one: SmoothedLog) -> float:
        return float(np.exp(np.mean([np.log(max(log.left_by(one), 1e-9)) for log in logs])))

    guesses = [one for one in longest.smoothings() if smoother or one.which is SmoothedColumn.TORQUE]
    if not guesses and smoother:
        guesses = list(longest.guesses((SmoothedColumn.POSITION,)))
    best = min(guesses, key=share, default=None)
    if best is None or share(best) > _LEFT_PERHAPS:
        return None
    best = longest.settled(best)
    slowest = _SLOWEST * longest.motion.rule.bandwidth_hz
    return best if share(best) <= _LEFT and best.smoothing.half_hz >= slowest else None


def _is_smoother_than_read(position: Vector, step: float) -> bool:
    """Whether a position has less of its encoder's rounding than reads of it have, in third differences, to which slow
    motion adds nothing; False where nobody said what the encoder's step is.

    An elastic drive makes a position too small beside its torque as a filter does: without this witness one would be
    taken for the other.
    """
    steps = np.diff(position)
    counts = steps[steps != 0.0] / max(step, 1e-300)
    by_whole_steps = bool(np.mean(np.abs(counts - np.round(counts)) < _WHOLE) > _ALMOST_ALL) if len(counts) else True
    scatter = _MEDIAN_TO_SIGMA * float(np.median(np.abs(np.diff(position, 3))))
    return step > 0.0 and not by_whole_steps and scatter < _SMOOTHER * _THIRD_DIFFERENCES * step


def _taken_back(table: SignalsTable, axis: str, one: SmoothedLog) -> SignalsTable:
    names = [f"{axis}.{signal}" for signal in _SIGNALS[one.which]]
    freed = {name: one.smoothing.undone(table.columns[name], table.period_s) for name in names}
    note = (
        f"{axis}: {one.text}: it was taken back as far as anything is left, and is scored to there; a log that was not "
        "smoothed says more"
    )
    columns = {**table.columns, **freed}
    return SignalsTable.of(table.axes, table.time_s, columns, table.repeat, table.source, (*table.notes, note))
