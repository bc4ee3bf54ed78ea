"""Reads of a position that were logged again: while the joint goes on, an encoder cannot read the same twice.

A bus that lost an answer, or a logger that is faster than its drive, writes what it had. Between such a row and the
next read the position jumps by the way of both, which a regression takes for two accelerations. Rows that no read
belongs to are made up from those around them. A row that came twice, with nothing made up for afterwards, is none,
and the clock counted it: such rows go where times may be counted anew. A drive that is a little slower than its log
looks alike, but its rows repeat at even places, and the clock is right.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals.kept_rows import Repair, RepairableError
from gimbal_hil.data.signals.table import SignalsTable

Floats = NDArray[np.float64]
#: the way of a row in encoder steps below which a read may well be the same again
_LEAST_STEPS = 4.0
#: rows in a row that hold one read
_MOST_ROWS = 10
#: a step that makes up for the rows before it is their way to this share of it; one that does not is a row's own
_SHARE = 0.3
#: steps below this share of the largest one are what adding whole turns rounds
_ROUNDING = 1e-6
#: of the rows of a motion this share may hold an old read
_MOST_HELD = 0.5
#: fewer reads say nothing of the way between them
_FEWEST_READS = 8
#: a beat of two clocks: as much of the places in one spectral line (a row's width alone takes 0.9 of it where every
#: fourth row repeats); of 400 draws at random twenty places reached it in 2 to 7 %, thirty in none, and fewer than that
#: are too few to tell; lines of periods up to so many rows
_EVEN, _LONGEST_BEAT = 0.75, 500
_LISTED = 3


def without_repeated_reads(table: SignalsTable, repair: Repair) -> SignalsTable:
    """The table with positions made up where the read before was logged again, and without rows that came twice; notes
    say which. A torque that came again in the same row is made up as well.

    Raises RepairableError for rows that came twice while a clock of the file's own went on, unless `repair` leaves out
    what is no measurement or states the rate.
    """
    held: dict[str, NDArray[np.bool_]] = {}
    again, twice = np.zeros(len(table), np.bool_), np.ones(len(table), np.bool_)
    for axis in table.axes:
        held[axis], one = _repeated(table.position(axis))
        _require_reads(table, axis, held[axis])
        again |= one
        twice &= (np.ediff1d(table.position(axis), to_begin=1.0) == 0.0) & _same_torque(table, axis)
    changed, notes = _made_up(table, held)
    table = table.but(changed, notes) if notes else table
    twice &= again
    if not twice.any() or any(np.any(one) for one in held.values()) or _at_even_places(twice):
        return table
    if not (repair.drop_invalid or repair.rate_hz is not None):
        raise RepairableError(
            f"{table.source or 'log'}: {_where(table, twice)}",
            f"came twice, as {np.count_nonzero(twice)} of {len(table)} rows did, and the clock went on",
            "rows that were measured once, with their times; --drop-invalid leaves out the others and counts the times",
            (Repair(drop_invalid=True),),
        )
    return _without_rows(table, twice)


def _at_even_places(rows: NDArray[np.bool_]) -> bool:
    """Whether the rows come as two clocks beat, also where some of them were not seen."""
    twice_as_fine = 2 * len(rows)
    lines = np.abs(np.fft.rfft(rows, twice_as_fine))[twice_as_fine // _LONGEST_BEAT :]
    return bool(np.max(lines, initial=0.0) >= _EVEN * np.count_nonzero(rows))


def _require_reads(table: SignalsTable, axis: str, held: NDArray[np.bool_]) -> None:
    """Raise BadInputError where more rows of a motion hold an old read than a new one: when those were made is known to
    a row or two only, and accelerations are not known at all.
    """
    moves = np.concatenate([[False], np.diff(table.position(axis)) != 0.0])
    if np.count_nonzero(held) <= _MOST_HELD * np.count_nonzero(held | moves):
        return
    hertz = np.count_nonzero(moves) / np.count_nonzero(held | moves) / table.period_s
    raise BadInputError(
        f"{table.source or 'log'}: {axis}.position",
        f"is read about {hertz:.3g} times a second, at uneven rows of a log of {1.0 / table.period_s:.4g} Hz",
        "the rows in which it was read, with their times",
    )


def _repeated(position: Floats) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Rows (n,) that hold the read before though the joint went on, as the next read shows; and single such rows (n,)
    after which nothing is made up for.
    """
    held, again = np.zeros(len(position), np.bool_), np.zeros(len(position), np.bool_)
    steps = np.diff(position)
    reads = np.flatnonzero(np.concatenate([[1.0], steps]))
    if len(reads) < _FEWEST_READS:
        return held, again
    rows = np.diff(reads)
    way = np.diff(position[reads]) / rows
    # the ways of a row before and after: at a turn they go apart, and a joint that turns may stand for a row
    before, after = np.concatenate([way[:1], way[:-1]]), np.concatenate([way[1:], way[-1:]])
    usual, least = 0.5 * (before + after), np.minimum(np.abs(before), np.abs(after))
    fast = (before * after > 0.0) & (least > _LEAST_STEPS * _step_of(steps))
    catches_up = fast & (rows > 1) & (rows <= _MOST_ROWS + 1) & (np.abs(way - usual) <= _SHARE * np.abs(usual))
    alone = fast & (rows == 2) & (np.abs(2.0 * way - usual) <= _SHARE * np.abs(usual))
    for found, marked in ((catches_up, held), (alone, again)):
        for k in np.flatnonzero(found):
            marked[reads[k] + 1 : reads[k + 1]] = True
    return held, again


def _step_of(steps: Floats) -> float:
    """The least way that the position went in a row: the step of its encoder, if the joint was ever that slow."""
    sizes = np.abs(steps)
    moving = sizes[sizes > _ROUNDING * np.max(sizes, initial=0.0)]
    return float(np.min(moving, initial=np.inf)) if len(moving) else 0.0


def _same_torque(table: SignalsTable, axis: str) -> NDArray[np.bool_]:
    """Rows (n,) whose torque is that of the row before; all where none was logged, as of an arm's other joints."""
    torque = table.columns.get(f"{axis}.torque")
    return np.ones(len(table), np.bool_) if torque is None else np.ediff1d(torque, to_begin=1.0) == 0.0


def _made_up(table: SignalsTable, held: dict[str, NDArray[np.bool_]]) -> tuple[dict[str, Floats], list[str]]:
    places = np.arange(len(table))
    columns: dict[str, Floats] = {}
    notes = []
    for axis, rows in held.items():
        if not rows.any():
            continue
        name, torque = f"{axis}.position", f"{axis}.torque"
        columns[name] = np.array(table.position(axis))
        columns[name][rows] = PchipInterpolator(places[~rows], columns[name][~rows])(places[rows])
        frames = rows & _same_torque(table, axis)
        usual = np.mean(_same_torque(table, axis)[~rows])
        both = bool(frames.any() and usual < 0.5 * np.mean(frames[rows]))
        if both:
            columns[torque] = np.array(table.commanded(axis))
            columns[torque][frames] = np.interp(places[frames], places[~frames], columns[torque][~frames])
        beside = f" (and {torque} in {np.count_nonzero(frames)} of them)" if both else ""
        notes.append(
            f"{name}: {np.count_nonzero(rows)} of {len(table)} rows hold the read of the row before though the joint "
            f"went on: they were made up from the reads around them{beside}, first {_where(table, rows)}"
        )
    return columns, notes


def _without_rows(table: SignalsTable, twice: NDArray[np.bool_]) -> SignalsTable:
    kept = np.flatnonzero(~twice)
    note = (
        f"{np.count_nonzero(twice)} of {len(table)} rows came twice, and the clock went on: they were left out, "
        f"first {_where(table, twice)}"
    )
    time_s = table.time_s[0] + table.period_s * np.arange(len(kept))
    columns = {name: values[kept] for name, values in table.columns.items()}
    laps = None if table.repeat is None else table.repeat[kept]
    some = SignalsTable.of(table.axes, time_s, columns, laps, table.source, (*table.notes, note))
    return replace(some, lines=None if table.lines is None else table.lines[kept], origins=table.origins)


def _where(table: SignalsTable, rows: NDArray[np.bool_]) -> str:
    found = np.flatnonzero(rows)[:_LISTED].tolist()
    at = "line" if table.lines is not None else "row"
    return ", ".join(f"{at} {row + 1 if table.lines is None else table.lines[row]}" for row in found)
