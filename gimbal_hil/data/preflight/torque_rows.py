"""Torques that cannot be: beyond the actuator, without their sign, or of a size that the motion did not answer."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

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
#: rows of a pulse that may be no motion's, and to either side those whose median it stands out from
_LONGEST_PULSE, _PULSE_AROUND = 8, 12
#: rows over which speed is taken before and after, and by which a drive may be late
_SPEED_ROWS, _LATE_ROWS = 5, 8
#: what such a torque should do to the speed is seen when this share of it is so many scatters; less was done
_ANSWERED, _SEEN = 0.25, 4.0
#: encoder steps that a joint that slides goes to either side of such a torque, and what its neighbours have of it; what
#: others have of its size that are of its kind
_SLIDES, _ALONE, _LIKE = 20.0, 0.3, 0.75
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


def torques_lost_beside(table: SignalsTable, axis: str, positions: Sequence[Impossible]) -> Iterator[Impossible]:
    """Torques of one number, a mark for none, in the rows whose position cannot be: such reads failed as a whole."""
    rows = np.array([row for one in positions if one.can_be_made_up for row in one.rows], np.int64)
    if len(marks := _marks(table.commanded(axis), rows)):
        what = "the same where the position cannot be: it marks reads that failed"
        yield Impossible(f"{axis}.torque", tuple(marks.tolist()), what)


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
    """Rows of pulses that stand out and would have changed the speed so that it shows, each by itself or all of them
    together, and did not.
    """
    pulses = _pulses(torque)
    step, period_s = model.number(axis, "encoder.step"), table.period_s
    per_torque = period_s / max(model.number(axis, model.own_inertia_path(axis)), 1e-12)
    asked, answers, slides = _answered(pulses, table.position(axis), torque, period_s, per_torque, step)
    if len(asked) == 0:
        return np.zeros(0, np.int64)
    sizes = np.array([abs(pulse.torque) / pulse.rows for pulse in pulses])
    single = np.array([pulse.beside for pulse in pulses]) < _ALONE * sizes
    large = sizes > _OF_ALL * float(np.quantile(np.abs(torque), _ALMOST_ALL))
    no_answer = np.max(answers, axis=1) < _ANSWERED * asked
    # friction may hold what lasts for rows; a single row of such a size is no motion's, whatever the joint does
    told = large & (slides | np.array([pulse.rows == 1 for pulse in pulses]))
    alone = told & (_ANSWERED * asked > _SEEN) & no_answer
    slides &= single & ~alone
    weights = asked[slides]
    squares = float(np.sum(weights**2))
    share = np.max(weights @ answers[slides], initial=0.0) / max(squares, 1e-300)
    # each torque by itself may be lost in the noise, and all of them together not
    together = _ANSWERED * np.sqrt(squares) > _SEEN and share < _ANSWERED
    unanswered = alone | slides if together else alone
    # then others of about their size are none either, at which the joint turned back
    usual = float(np.median(sizes[unanswered])) if np.any(unanswered) else np.inf
    like = single & no_answer & (sizes > _LIKE * usual)
    rows = [
        np.arange(one.first, one.first + one.rows)
        for one, is_so in zip(pulses, unanswered | like, strict=True)
        if is_so
    ]
    return np.concatenate([np.zeros(0, np.int64), *rows])


@dataclass(frozen=True)
class _Pulse:
    """Rows in a row whose torque stands out to one side: the first, how many, by how much in all, and by how much the
    larger of its neighbours does.
    """

    first: int
    rows: int
    torque: float
    beside: float


def _pulses(torque: Floats) -> list[_Pulse]:
    """All that are short enough to be no motion's and far enough from both ends to see what they did."""
    off = torque - median_around(torque, _PULSE_AROUND)
    stands_out = np.abs(off) > np.maximum(_STANDS_OUT * scatter_of(off), _BESIDE * _around(np.abs(off)))
    side = np.sign(off) * stands_out
    edges = np.flatnonzero(np.diff(side, prepend=0.0, append=0.0))
    found = []
    for first, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        reach = _reach_of(end - first)
        if side[first] != 0.0 and end - first <= _LONGEST_PULSE and reach < first < end < len(torque) - reach:
            beside = float(max(abs(off[first - 1]), abs(off[end])))
            found.append(_Pulse(first, end - first, float(np.sum(off[first:end])), beside))
    return found


def _reach_of(rows: int) -> int:
    """Rows to either side that tell what a pulse of so many did."""
    return 2 * (_SPEED_ROWS + rows) + _LATE_ROWS


def _answered(
    pulses: Sequence[_Pulse], position: Floats, torque: Floats, period_s: float, per_torque: float, step: float
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Of each pulse, in units of what noise makes of such a change: by how much it should change the speed (n,), by how
    much that changed to its side, so many rows later (n, late); and whether the joint slides on through it (n,).
    """
    asked, answers, slides = np.zeros(len(pulses)), np.zeros((len(pulses), _LATE_ROWS + 1)), []
    # where the torque without its pulses would have led to
    led_to = np.cumsum(np.cumsum(median_around(torque, _PULSE_AROUND))) * per_torque * period_s
    changes: dict[int, tuple[Floats, float]] = {}
    for k, pulse in enumerate(pulses):
        if pulse.rows not in changes:
            change = _unexplained(*(_changes_of_speed(one, pulse.rows, period_s) for one in (position, led_to)))
            changes[pulse.rows] = change, max(scatter_of(change), step / (_SPEED_ROWS * period_s))
        change, noise = changes[pulse.rows]
        late = change[pulse.first : pulse.first + _LATE_ROWS + 1]
        asked[k], answers[k] = abs(pulse.torque) * per_torque / noise, late * np.sign(pulse.torque) / noise
        # a joint that sticks answers nothing, one that turns back changes its friction, and one that is slow stops
        first, last, reach = pulse.first, pulse.first + pulse.rows - 1, _reach_of(pulse.rows)
        before, after = position[first] - position[first - reach], position[last + reach] - position[last]
        least = max(_SLIDES * step, _ANSWERED * abs(pulse.torque) * per_torque * reach * period_s)
        slides.append(min(abs(before), abs(after)) > least and before * after > 0.0)
    return asked, answers, np.array(slides, np.bool_)


def _unexplained(change: Floats, explained: Floats) -> Floats:
    """What of changes (n,) is no multiple of those that are explained (n,)."""
    squares = float(explained @ explained)
    return change - (float(change @ explained) / squares if squares > 0.0 else 0.0) * explained


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

    return np.asarray(percentile_filter(sizes, _BESIDE_SHARE, 4 * _PULSE_AROUND + 1, mode="mirror"))


def _changes_of_speed(position: Floats, rows: int, period_s: float) -> Floats:
    """By how much the speed after a pulse of so many rows that begins with each row differs from that before, beyond
    what it does to either side, (n,).
    """
    n, k = len(position), _SPEED_ROWS
    speed = (position[k:] - position[:-k]) / (k * period_s)
    change = np.zeros(n)
    change[k : n - k - rows] = speed[k + rows :] - speed[: n - 2 * k - rows]
    apart = k + rows
    changed = np.zeros(n)
    inside = slice(k + apart, n - k - rows - apart)
    changed[inside] = change[inside] - 0.5 * (
        change[k + 2 * apart : n - k - rows] + change[k : n - k - rows - 2 * apart]
    )
    return changed
