"""Torques that cannot be: beyond the actuator, without their sign, or of a size that the motion did not answer."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.data.preflight.held_torque import held_torques
from gimbal_hil.data.preflight.impossible import (
    AROUND,
    MOST_REPAIRED,
    ColumnFault,
    Floats,
    Impossible,
    median_around,
    scatter_of,
)
from gimbal_hil.data.signals import SignalsTable
from sim_backend.model import AntennaModel

#: times the actuator's limit, or where none is stated times the size that all but one row in fifty have; a loop answers
#: a step with many times what it asks for afterwards
_LIMITS, _TORQUES, _ALMOST_ALL = 1.2, 20.0, 0.98
#: a number without its sign is near the top of its range, and its neighbours near zero, within this share of it
_NEAR = 0.1
#: a torque stands out by so many times the scatter of the log, by this share of the torques that it has, and by so many
#: times what all but one row in five around it do: a loop at its limit chatters, and of that a joint answers little
_STANDS_OUT, _OF_ALL, _BESIDE, _BESIDE_SHARE = 20.0, 0.3, 3.0, 80.0
#: rows over which speed is taken before and after, and by which a drive may be late
_SPEED_ROWS, _LATE_ROWS = 5, 8
#: what such a torque should do to the speed is seen when this share of it is so many scatters; less was done
_ANSWERED, _SEEN = 0.25, 4.0
#: encoder steps that a joint that slides goes to either side of such a torque, and what its neighbours have of it
_SLIDES, _ALONE = 20.0, 0.3
#: so many such torques of one number, and this share of them, are a mark, in rows that stand out by so many scatters
_FEWEST_MARKS, _ALL_MARKS, _MARKED = 5, 0.9, 5.0
#: a saturated loop goes beyond the limit in steps below this share of it
_STEP_OF_A_LOOP = 0.3

_UNSIGNED = "as a signed number does that is read without its sign"


def impossible_torques(model: AntennaModel, table: SignalsTable, axis: str) -> Iterator[Impossible]:
    """What cannot be in the torque of one axis, the first kind that is found."""
    column, torque = f"{axis}.torque", table.commanded(axis)
    limit = model.number(axis, "actuator.limit")
    size = _LIMITS * limit if limit > 0.0 else _TORQUES * float(np.quantile(np.abs(torque), _ALMOST_ALL))
    if len(torque) < 4 * AROUND or size == 0.0:
        return
    beyond = np.flatnonzero(np.abs(torque) > size)
    most = float(np.max(np.abs(torque)))
    if len(beyond) and _lost_signs(torque[beyond], size):
        yield Impossible(column, tuple(beyond.tolist()), f"beyond the actuator, {_UNSIGNED}", ColumnFault.UNSIGNED)
    elif (rows := _tops(torque, most)) is not None:
        what = f"is never negative and jumps to the top of its range, {_UNSIGNED}"
        yield Impossible(column, rows, what, ColumnFault.UNSIGNED)
    elif limit > 0.0 and (torque.min() >= 0.0 or torque.max() <= 0.0) and float(np.median(np.abs(torque))) > limit:
        what = "beyond the actuator and never of the other sign, as numbers are that are not counted from zero"
        yield Impossible(column, tuple(np.flatnonzero(np.abs(torque) > limit).tolist()), what, ColumnFault.ZERO)
    else:
        yield from _not_given(model, table, axis, torque, _jumped(torque, beyond, size) if limit > 0.0 else beyond)


def _not_given(
    model: AntennaModel, table: SignalsTable, axis: str, torque: Floats, beyond: NDArray[np.int64]
) -> Iterator[Impossible]:
    """Torques that the actuator cannot give, or that did nothing to the motion, or that were held, the first kind."""
    column, few = f"{axis}.torque", MOST_REPAIRED * len(torque)
    if 0 < len(beyond) <= few:
        yield Impossible(column, tuple(beyond.tolist()), "with a torque that the actuator cannot give")
    elif len(beyond) == 0:
        without = _unanswered(model, table, axis, torque)
        if len(marks := _marks(torque, without)):
            what = "which did nothing to the motion, the same in many single rows: it marks reads that failed"
            yield Impossible(column, tuple(marks.tolist()), what)
        elif len(without):
            yield Impossible(column, tuple(without.tolist()), "which did nothing to the motion")
        else:
            yield from held_torques(model, table, axis)


def _jumped(torque: Floats, beyond: NDArray[np.int64], size: float) -> NDArray[np.int64]:
    """Of rows beyond the actuator those in a stretch that begins or ends with a step which a loop does not make: that
    comes there and goes in small ones, and the actuator gives what it can.
    """
    if len(beyond) == 0:
        return beyond
    stretches = np.split(beyond, np.flatnonzero(np.diff(beyond) > 1) + 1)
    steps = np.abs(np.diff(torque, prepend=torque[:1], append=torque[-1:]))
    jumps = [part for part in stretches if max(steps[part[0]], steps[part[-1] + 1]) > _STEP_OF_A_LOOP * size]
    return np.concatenate([beyond[:0], *jumps])


def _lost_signs(beyond: Floats, size: float) -> bool:
    """Whether torques beyond the actuator are what negative ones become: all up at one top, none alike a mark for "no
    value".
    """
    return bool(beyond.min() > 2.0 * size and np.ptp(beyond) <= size and len(np.unique(beyond)) > 2)


def _tops(torque: Floats, most: float) -> tuple[int, ...] | None:
    """Rows near the top of a column that is never negative, where it goes there and back between neighbours near
    zero; None where it does not.
    """
    if torque.min() < 0.0:
        return None
    high, low = torque > (1.0 - _NEAR) * most, torque < _NEAR * most
    over_the_edge = np.count_nonzero((high[1:] & low[:-1]) | (low[1:] & high[:-1]))
    both = 0.02 < high.mean() < 0.98 and bool(np.all(high | low))
    # numbers of a narrower range fill it, but still go from its bottom to its top between two rows, never across
    across = np.count_nonzero(np.abs(np.diff(torque)) > 0.5 * most)
    if both or (over_the_edge >= AROUND and over_the_edge > 0.8 * across):
        return tuple(np.flatnonzero(high)[:1].tolist())
    return None


def _unanswered(model: AntennaModel, table: SignalsTable, axis: str, torque: Floats) -> NDArray[np.int64]:
    """Rows whose torque stands out and would have changed the speed so that it shows, each by itself or all of them
    together, and did not.
    """
    off = torque - median_around(torque)
    least = np.maximum(_STANDS_OUT * scatter_of(off), _BESIDE * _around(np.abs(off)))
    reach = 2 * (_SPEED_ROWS + 1) + _LATE_ROWS
    rows = np.flatnonzero(np.abs(off) > least)
    rows = rows[(rows > reach) & (rows < len(torque) - reach - 1)]
    if len(rows) == 0:
        return rows
    position, step = table.position(axis), model.number(axis, "encoder.step")
    changes = _changes_of_speed(position, table.period_s)
    noise = max(scatter_of(changes), step / (_SPEED_ROWS * table.period_s))
    asked = off[rows] * table.period_s / max(model.number(axis, model.own_inertia_path(axis)), 1e-12)
    answers = changes[rows[:, None] + 1 + np.arange(_LATE_ROWS + 1)] * np.sign(asked)[:, None]
    large = np.abs(off[rows]) > _OF_ALL * float(np.quantile(np.abs(torque), _ALMOST_ALL))
    seen = _ANSWERED * np.abs(asked)
    alone = large & (seen > _SEEN * noise) & (np.max(answers, axis=1) < seen)
    # a joint that sticks answers nothing, one that turns back changes its friction, and a single row is no motion's
    before, after = position[rows] - position[rows - reach], position[rows + reach] - position[rows]
    single = np.maximum(np.abs(off[rows - 1]), np.abs(off[rows + 1])) < _ALONE * np.abs(off[rows])
    slides = single & (np.minimum(np.abs(before), np.abs(after)) > _SLIDES * step) & (before * after > 0.0) & ~alone
    weights = np.abs(asked[slides])
    squares = float(np.sum(weights**2))
    share = np.max(weights @ answers[slides], initial=0.0) / max(squares, 1e-300)
    # each torque by itself may be lost in the noise, and all of them together not
    together = _ANSWERED * np.sqrt(squares) > _SEEN * noise and share < _ANSWERED
    unanswered = alone | slides if together else alone
    # then those as large are none either, at which the joint turned back
    like = single & (np.abs(off[rows]) >= np.min(np.abs(off[rows[unanswered]]), initial=np.inf))
    return np.asarray(rows[unanswered | like])


def _marks(torque: Floats, without: NDArray[np.int64]) -> NDArray[np.int64]:
    """All rows that hold the one number of rows whose torque did nothing to the motion, and stand out; none where those
    rows hold several numbers, as a loop that chatters does.
    """
    if len(without) < _FEWEST_MARKS:
        return without[:0]
    numbers, often = np.unique(torque[without], return_counts=True)
    mark = numbers[int(np.argmax(often))]
    off = np.abs(torque - median_around(torque))
    rows = np.flatnonzero((torque == mark) & (off > _MARKED * scatter_of(off)))
    return rows if often.max() > _ALL_MARKS * len(without) else without[:0]


def _around(sizes: Floats) -> Floats:
    """What all but one in five of the rows around each one do not exceed, (n,)."""
    from scipy.ndimage import percentile_filter

    return np.asarray(percentile_filter(sizes, _BESIDE_SHARE, 4 * AROUND + 1, mode="mirror"))


def _changes_of_speed(position: Floats, period_s: float) -> Floats:
    """By how much the speed after each row differs from that before, beyond what it does to either side, (n,)."""
    n, k = len(position), _SPEED_ROWS
    speed = np.zeros(n)
    speed[: n - k] = (position[k:] - position[:-k]) / (k * period_s)
    change = np.zeros(n)
    change[k:] = speed[k:] - speed[:-k]
    apart = k + 1
    beside = np.zeros(n)
    beside[apart : n - apart] = 0.5 * (change[2 * apart :] + change[: n - 2 * apart])
    changed = change - beside
    changed[: 2 * apart] = changed[n - 2 * apart :] = 0.0
    return changed
