"""Is this a signals table? Every way in which a file may fail to be one, refused by name or repaired on request."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.documents import LARGEST_NUMBER
from firmware_protocol.errors import BadInputError
from gimbal_hil.data.containers import command_line, time_among
from gimbal_hil.data.signals.clock import evened, smaller_unit, with_counted_times
from gimbal_hil.data.signals.guessing import guessed_words, is_read_by
from gimbal_hil.data.signals.kept_rows import (
    FEWEST_ROWS,
    Repair,
    RepairableError,
    forward_rows,
    require_rows,
    steady_rows,
    unparted_rows,
)
from gimbal_hil.data.signals.resampling import resample_rows, shifted
from gimbal_hil.data.signals.table import (
    BASE_ANGLES,
    REPEAT,
    TIME,
    TORQUES,
    SignalsTable,
    column_names,
)
from gimbal_hil.data.signals.torque_columns import with_torques
from gimbal_hil.data.tables import RawColumns, listed

#: how a note of rows whose rate a person stated ends
STATED_RATE = "as --rate says"
#: share of the cells of a column that a repair may leave out though something is written there
_MOST_NOT_UNDERSTOOD = 0.02
#: a repair that keeps less of a log is not proposed
_WORTH_KEEPING = 0.25


@dataclass(frozen=True)
class AxisNames:
    """The axes that a log is read for, what turns a current into torque (N m/A, N/A) by axis, where the model states
    it, whether the axes turn, and what the model is called, if there is one.
    """

    axes: tuple[str, ...]
    torque_constants: Mapping[str, float] = field(default_factory=dict)
    rotary: bool = True
    model: str = ""
    #: of these axes a position is enough
    passive: tuple[str, ...] = ()


def checked_table(raw: RawColumns, named: AxisNames, repair: Repair) -> SignalsTable:
    """The table in a file; raises BadInputError that names file, row and column, and the repairs that would do."""
    try:
        return _table(raw, named, repair)[0]
    except RepairableError as refused:
        remedies = _remedies(raw, named, repair, refused.trials)
        expected = f"{refused.expected}; {remedies}" if remedies else refused.expected
        raise BadInputError(refused.where, refused.problem, expected) from None


def _remedies(raw: RawColumns, named: AxisNames, repair: Repair, trials: Sequence[Repair]) -> str:
    """The options that would make a table of it: each was tried."""
    found = []
    for trial in trials:
        tried = replace(
            repair, resample=repair.resample or trial.resample, drop_invalid=repair.drop_invalid or trial.drop_invalid
        )
        try:
            table, kept = _table(raw, named, tried)
        except BadInputError:
            continue
        if (unit := smaller_unit(table.period_s)) is not None:
            # what would be refused next
            option = command_line([f"{TIME}={raw.called.get(TIME, TIME)}:{unit[1]}"])
            return f"in seconds, where rows are {table.period_s:.4g} apart: {option} for {unit[0]}"
        rows = len(next(iter(raw.values.values()))) + len(raw.odd)
        if kept >= _WORTH_KEEPING * rows:
            found.append(f"{'--resample' if trial.resample else '--drop-invalid'} (keeps {kept} of {rows} rows)")
    return f"{' or '.join(found)} accepts such a log" if found else ""


def _table(raw: RawColumns, named: AxisNames, repair: Repair) -> tuple[SignalsTable, int]:
    """The table, and how many rows of the file it was made from."""
    axes, drop_invalid = named.axes, repair.drop_invalid
    raw, repair = _timed(raw, repair)
    resample = repair.to_grid
    names, notes = _known_columns(raw, named)
    notes[:0] = raw.notes
    raw = _measurable(raw, names)
    if resample or drop_invalid:
        raw = _turned_round(raw, notes)
    rows = _valid_rows(raw, names, resample, drop_invalid, notes)
    raw = with_counted_times(raw, rows, resample or drop_invalid, repair.period_s, notes)
    rows = forward_rows(raw, rows, resample or drop_invalid, notes)
    require_rows(raw, len(rows))
    if named.rotary:
        raw = _turned_on(raw, rows, axes, notes)
    if resample:
        rows = unparted_rows(raw, rows, notes)
        time_s, columns, laps = resample_rows(raw, rows, names, notes, repair.period_s)
    else:
        rows = steady_rows(raw, rows, drop_invalid, notes)
        time_s = evened(raw.values[TIME][rows])
        columns = {name: raw.values[name][rows] for name in names if name not in (TIME, REPEAT)}
        laps = raw.values[REPEAT][rows] if REPEAT in names else None
    for name in BASE_ANGLES:
        if name in columns:
            columns[name] = np.unwrap(columns[name])
    for name, shift in raw.shifts_s.items():
        if name in columns:
            columns[name] = shifted(name, time_s, columns[name], shift)
            way = "later" if shift > 0.0 else "earlier"
            notes.append(f"{name} was taken {1e3 * abs(shift):.6g} ms {way} than the rows that it stands in, as stated")
    driven = tuple(axis for axis in axes if axis not in named.passive)
    columns = with_torques(columns, driven, named.torque_constants, notes)
    repeat = None if laps is None else laps.astype(np.int64)
    table = SignalsTable.of(axes, time_s, columns, repeat, str(raw.path), notes)
    return replace(table, lines=_lines(raw, rows, time_s), origins=raw.origins), len(rows)


def _lines(raw: RawColumns, rows: NDArray[np.int64], time_s: NDArray[np.float64]) -> NDArray[np.int64] | None:
    """The line of each time (n,) in a file of text: of the row there, or of the last one before."""
    if raw.lines is None:
        return None
    before = np.searchsorted(raw.values[TIME][rows], time_s + 0.5 * float(np.min(np.diff(time_s))), side="right") - 1
    return np.asarray(raw.lines[rows[np.maximum(before, 0)]])


def _turned_round(raw: RawColumns, notes: list[str]) -> RawColumns:
    """A file whose rows run backwards in time, from its last row to its first; another as it is."""
    time_s = raw.values[TIME][np.isfinite(raw.values[TIME])]
    if len(time_s) < FEWEST_ROWS or not np.all(np.diff(time_s) < 0.0):
        return raw
    notes.append("its rows run backwards in time and were read from the last to the first")
    last = len(raw.values[TIME]) - 1
    return replace(
        raw,
        values={name: values[::-1] for name, values in raw.values.items()},
        texts={name: {last - row: text for row, text in texts.items()} for name, texts in raw.texts.items()},
        lines=None if raw.lines is None else raw.lines[::-1],
    )


def _measurable(raw: RawColumns, names: Sequence[str]) -> RawColumns:
    """Without numbers that overflow in the first square: nobody measures them."""
    values, texts = dict(raw.values), dict(raw.texts)
    for name in names:
        beyond = np.abs(values[name]) > LARGEST_NUMBER
        if beyond.any():
            texts[name] = {**texts[name], **{int(row): f"{values[name][row]:g}" for row in np.flatnonzero(beyond)}}
            values[name] = np.where(beyond, np.nan, values[name])
    return replace(raw, values=values, texts=texts)


def _timed(raw: RawColumns, repair: Repair) -> tuple[RawColumns, Repair]:
    """A file that has no times with those that its rows have at the stated rate."""
    if TIME in raw.values and repair.rate_hz is not None and _numbers_rows(raw.values[TIME]):
        note = f"its times are the numbers of its rows: they were taken as {repair.rate_hz:g} a second, {STATED_RATE}"
        values = {**raw.values, TIME: raw.values[TIME] / repair.rate_hz}
        return replace(raw, values=values, notes=(*raw.notes, note)), replace(repair, rate_hz=None, resample=True)
    if TIME in raw.values or repair.rate_hz is None or repair.period_s is None or time_among(raw.values)[0] is not None:
        return raw, repair
    for line in raw.odd[:1]:
        raise BadInputError(
            f"{raw.path}: line {line.line}",
            f"is no row ({line.text!r}), and of a log without times none can be left out",
            "rows alone, or a column of times",
        )
    rows = len(next(iter(raw.values.values())))
    note = f"has no times: its {rows} rows were taken as {repair.rate_hz:g} a second, {STATED_RATE}"
    values = {TIME: np.arange(rows, dtype=np.float64) * repair.period_s, **raw.values}
    timed = replace(raw, values=values, texts={TIME: {}, **raw.texts}, notes=(*raw.notes, note))
    return timed, replace(repair, rate_hz=None)


def _numbers_rows(times: NDArray[np.float64]) -> bool:
    """Whether times count by one from row to row, up or down, which no clock in seconds does."""
    steps = np.diff(times[np.isfinite(times)])
    return len(steps) > FEWEST_ROWS and abs(float(np.median(steps))) == 1.0 and bool(np.all(steps % 1.0 == 0.0))


def _turned_on(raw: RawColumns, rows: NDArray[np.int64], axes: Sequence[str], notes: list[str]) -> RawColumns:
    """Positions of encoders that begin again after each turn, carried on over whole turns.

    A change of more than half a turn from row to row is such a beginning where all others are below a quarter, and the
    rest of it, whole turns taken off, is no larger than they are.
    """
    values = dict(raw.values)
    for axis in axes:
        position = values[f"{axis}.position"]
        kept = rows[np.isfinite(position[rows])]
        changes = np.diff(position[kept])
        far = np.abs(changes) > np.pi
        rest = (changes[far] + np.pi) % (2.0 * np.pi) - np.pi
        usual = float(np.max(np.abs(changes[~far]), initial=0.0))
        if not far.any() or usual > 0.5 * np.pi or np.max(np.abs(rest)) > 2.0 * usual:
            continue
        for name in (f"{axis}.position", f"{axis}.position_ref"):
            if name in values:
                values[name] = values[name].copy()
                values[name][kept] = np.unwrap(values[name][kept])
        notes.append(
            f"{axis}.position begins again {np.count_nonzero(far)} times, first at"
            f" {raw.where(int(kept[np.argmax(far) + 1]), f'{axis}.position')}: whole turns were added there"
        )
    return replace(raw, values=values)


def _known_columns(raw: RawColumns, named: AxisNames) -> tuple[list[str], list[str]]:
    """Columns that the table takes; raises when a required one is missing."""
    axes = named.axes
    driven = [f"{axis}.torque" for axis in axes if axis not in named.passive]
    required = (TIME, *driven, *(f"{axis}.position" for axis in axes))
    for name in required:
        axis, _, signal = name.rpartition(".")
        if signal == "torque" and name not in raw.values and f"{axis}.torque_sampled" in raw.values:
            continue
        if signal == "torque" and name not in raw.values and f"{axis}.current" in raw.values:
            if axis not in named.torque_constants:
                raise BadInputError(
                    f"{raw.path}: column {axis}.current", "is in amperes and the model does not say what torque they "
                                                          "make",
                    f"axes.{axis}.actuator.torque_constant in the model, or in place of the current --column "
                    f"'{name}={raw.called.get(f'{axis}.current', 'COLUMN')}:KT*N m' with N m per ampere for KT",
                )  # fmt: skip
        elif name not in raw.values:
            raw.require_certain(name)
            raise _without(raw, name, named)
    allowed = (TIME, REPEAT, *column_names(axes))
    given = {axis: [f"{axis}.{signal}" for signal in TORQUES if f"{axis}.{signal}" in raw.values] for axis in axes}
    unused = [name for names in given.values() for name in names[1:]]
    notes = [f"{name} was not used: the file has the torque itself" for name in unused]
    notes += [
        f"column {name!r} is not one of a signals table and was left out" for name in raw.values if name not in allowed
    ]
    names = [name for name in allowed if name in raw.values and name not in unused]
    for name in names:
        raw.require_certain(name)
    return names, notes


def _without(raw: RawColumns, name: str, named: AxisNames) -> BadInputError:
    """The refusal of a file that lacks a column: what it may be called there, and the words that would say so."""
    present = list(raw.values)
    near = difflib.get_close_matches(name, present, 1)
    of_model = f" of the model {named.model!r}" if named.model else ""
    axes = f"the axes {', '.join(named.axes)}{of_model}"
    hint = f"this column of {axes} (the file has {near[0]!r})" if near else f"this column for {axes}"
    if all(one.isdecimal() for one in present):
        others = f", or --column {name}=NUMBER:UNIT: the file has no header, and the columns {listed(present)}"
    else:
        others = f", or --column {name}=COLUMN:UNIT with what the file calls it ({listed(present)})"
        words = guessed_words(raw, named.axes)
        if is_read_by(words, named.axes):
            others += f"; their names suggest {command_line(words)}"
    if name == TIME and time_among(raw.values)[0] is None:
        others += ", or --rate HZ for rows that have no times"
    return BadInputError(str(raw.path), f"has no column {name!r}", hint + others + raw.doubt_of_encoding)


def _valid_rows(
    raw: RawColumns, names: Sequence[str], resample: bool, drop_invalid: bool, notes: list[str]
) -> NDArray[np.int64]:
    for line in raw.odd[:1]:
        if not (resample or drop_invalid):
            raise RepairableError(
                f"{raw.path}: line {line.line}",
                f"has {line.cells} cells where the header has {line.wanted}: {line.text!r}",
                "one cell a column",
            )
        notes.append(
            f"{len(raw.odd)} lines that are no rows were left out, the first is line {line.line}: {line.text!r}"
        )
    invalid = {name: np.isnan(raw.values[name]) for name in names}
    if REPEAT in invalid:
        invalid[REPEAT] = invalid[REPEAT] | (raw.values[REPEAT] % 1 != 0)
    bad = np.any(list(invalid.values()), axis=0)
    if not bad.any():
        return np.arange(len(bad))
    row = int(np.argmax(bad))
    column = next(name for name in names if invalid[name][row])
    _require_understood(raw, names)
    if not (resample or drop_invalid):
        raise RepairableError(
            raw.where(row, column),
            _what(raw, row, column),
            f"a finite number; rows without one: {np.count_nonzero(bad)}",
        )
    notes.append(
        f"{np.count_nonzero(bad)} of {len(bad)} rows held no number somewhere, first at {raw.where(row, column)}"
    )
    for name in names:
        if invalid[name].all():
            raise BadInputError(f"{raw.path}: column {name}", "holds no number at all", "a number in every row")
    return np.flatnonzero(~bad if drop_invalid else ~invalid[TIME])


def _require_understood(raw: RawColumns, names: Sequence[str]) -> None:
    """Raise BadInputError where many cells of a column are written in a way that is not understood: they have digits,
    so they hold values, and what is left without them (all negative ones, perhaps) is no log of the same motion.
    """
    for name in names:
        written = [row for row, text in raw.texts[name].items() if any(map(str.isdigit, text))]
        if len(written) > _MOST_NOT_UNDERSTOOD * len(raw.values[name]):
            row = min(written)
            raise BadInputError(
                raw.where(row, name),
                f"holds {raw.texts[name][row]!r}; cells that hold no number as programs write it: {len(written)}",
                "a finite number such as -1.25e-3; these cells hold values, so no option leaves them out",
            )


def _what(raw: RawColumns, row: int, column: str) -> str:
    text = raw.texts[column].get(row)
    if text is not None:
        return f"holds {text!r}"
    value = raw.values[column][row]
    return "is empty or not a number" if np.isnan(value) else f"is {value:g}, no whole number"
