"""Columns of somebody else's file as those of a signals table: their names there, their units and signs."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals.source_terms import Term, terms_of, without_time, wrapped_on
from gimbal_hil.data.signals.table import REPEAT, TIME, TORQUES, column_names
from gimbal_hil.data.signals.units import unit_of
from gimbal_hil.data.tables import (
    BETWEEN_ROWS_S,
    DAY_S,
    UNITS,
    FileColumn,
    Floats,
    RawColumns,
    knows_all_units,
    listed,
    unit_in_name,
    unit_size,
)

_PAIR = "NAME=COLUMN, NAME=COLUMN:UNIT or NAME=COLUMN@TIME:UNIT, as in azimuth.position=theta_deg:deg"
#: names of a part of the time that say that it is in nanoseconds or microseconds, as stamps of ROS and POSIX do
_PARTS = {
    "ns": re.compile(r"(?:^|[._])(?:nano_?se?cs?|nanoseconds|nsecs?|ns)$", re.IGNORECASE),
    "us": re.compile(r"(?:^|[._])(?:micro_?se?cs?|microseconds|usecs?|us)$", re.IGNORECASE),
}
#: sizes of units that differ by less are one
_SAME_SIZE = 1e-6
_NUMBER = r"\d+(?:\.\d*)?(?:[eE][+-]?\d+)?"
_MIRRORED = "-"
_UNIT = re.compile(rf"(?P<sign>-?)(?:(?P<times>{_NUMBER})\*?)?(?P<unit>[^\d].*?)?(?:/(?P<over>{_NUMBER}))?")


@dataclass(frozen=True)
class ColumnMap:
    """Column of a signals table -> column of the file, with `:UNIT` where that is not SI; nothing is left as it is.

    A minus before the unit mirrors the column, a number multiplies or divides it: `:-deg`, `:turn/8192`, `:0.062*N m`.
    `COLUMN%65536` is a counter that begins again there, `sec+nanosec:ns` the sum of two columns. Without `:UNIT` the
    unit counts that the file states. `@-2ms` after the column says that its values belong 2 ms earlier than the rows
    that they stand in, `@0ms` that they belong where they stand.
    """

    sources: Mapping[str, str]

    def states_time_of(self, axis: str) -> bool:
        """Whether it says when the torque of an axis was in force."""
        torques = (self.sources.get(f"{axis}.{signal}", "") for signal in TORQUES)
        return any(without_time(source)[1] is not None for source in torques)

    @classmethod
    def of_words(cls, words: Sequence[str] | None, option: str = "--column") -> ColumnMap:
        """From words `NAME=COLUMN[:UNIT]`; BadInputError for one that is none, or for a name that comes twice."""
        found: dict[str, str] = {}
        for word in words or ():
            name, equals, source = (part.strip() for part in word.partition("="))
            if not (name and equals and source):
                raise BadInputError(f"{option} {word}", "is no pair", _PAIR)
            if name in found:
                raise BadInputError(f"{option} {word}", f"is the second column for {name}", "every name once")
            found[name] = source
        return cls(MappingProxyType(found))

    def read(self, raw: RawColumns, axes: Sequence[str], linear: bool) -> RawColumns:
        """The file with these columns under their names and in SI units.

        A column that is taken loses the name that it has in the file. A file that has none of these columns, but those
        of a signals table, is left as it is, but for units that it states. Raises BadInputError for a name that no such
        table has, a column that the file does not have, and a unit of something else.
        """
        known = tuple(raw.values)
        found = {name: self._terms(name, known, axes) for name in self.sources}
        missing = [name for name, terms in found.items() if terms is None]
        if len(missing) == len(found) and all(name in raw.values for name in found):
            own = [name for name in (TIME, REPEAT, *column_names(axes)) if name in raw.units]
            found, missing = {name: (Term(name),) for name in own}, []
        for name in missing:
            raise _not_there(raw, name, without_time(self.sources[name], known)[0])
        split = {name: terms for name, terms in found.items() if terms is not None}
        raw = _with_named_units(raw, split, axes if linear else ())
        taken = {term.column for terms in split.values() for term in terms} | set(split)
        values = {name: column for name, column in raw.values.items() if name not in taken}
        texts = {name: raw.texts[name] for name in values}
        for name, terms in split.items():
            for term in terms:
                raw.require_certain(term.column)
            si = unit_of(name, axes if linear else ())
            if len(terms) == 1:
                _require_agreement(name, terms[0], si, raw.units)
            values[name] = _summed(raw, name, terms, si)
            texts[name] = {row: text for term in terms for row, text in raw.texts[term.column].items()}
        alone = {name: terms[0] for name, terms in split.items() if len(terms) == 1 and terms[0].wrap is None}
        origins = {
            name: FileColumn(
                term.column, term.unit, _size(term, name, unit_of(name, axes if linear else ()), raw.units)[0]
            )
            for name, term in alone.items()
        }
        # what the file calls otherwise is certain now, whatever it has that name
        doubts = {name: doubt for name, doubt in raw.doubts.items() if name not in split}
        called = {name: "+".join(term.column for term in terms) for name, terms in split.items()}
        stated = [f"{name} is in {raw.units[terms[0].column]}, as the file says" for name, terms in split.items() if (
            len(terms) == 1 and not terms[0].unit and terms[0].column in raw.units
        )]  # fmt: skip
        shifts = {name: shift for name in split if (shift := self._shift(name, known))}
        return replace(
            raw,
            values=values,
            texts=texts,
            called=called,
            origins=origins,
            doubts=doubts,
            notes=(*raw.notes, *stated),
            shifts_s=shifts,
        )

    def _shift(self, name: str, known: Sequence[str]) -> float:
        """Seconds by which a column belongs later than its rows."""
        shift = without_time(self.sources.get(name, ""), known)[1]
        if shift is not None and name in (TIME, REPEAT):
            raise BadInputError(
                f"--column {name}={self.sources[name]}", f"shifts {name}", "a shift of a column against it"
            )
        return shift or 0.0

    def _terms(self, name: str, known: Sequence[str], axes: Sequence[str]) -> tuple[Term, ...] | None:
        allowed = (TIME, REPEAT, *column_names(axes))
        source = self.sources[name]
        if name not in allowed:
            near = difflib.get_close_matches(name, allowed, 1)
            hint = f"{near[0]!r}, perhaps; all: " if near else ""
            raise BadInputError(
                f"--column {name}={source}", f"a signals table has no column {name!r}", hint + ", ".join(allowed)
            )
        return terms_of(without_time(source, known)[0], known)


def _with_named_units(raw: RawColumns, split: Mapping[str, Sequence[Term]], linear: Sequence[str]) -> RawColumns:
    """The file with the units that the names of these columns end in, where it states none otherwise."""
    named = {
        term.column: unit
        for name, terms in split.items()
        for term in terms
        if (unit := unit_in_name(term.column, unit_of(name, linear)))
    }
    return replace(raw, units={**named, **raw.units})


def _is_said(term: Term) -> bool:
    """Whether somebody said more of a column than that it is mirrored."""
    return term.unit not in ("", _MIRRORED)


def _require_agreement(name: str, term: Term, si: str, stated: Mapping[str, str]) -> None:
    """Raise BadInputError where another unit is said than the one that the file states, and no factor with it."""
    written = stated.get(term.column, "")
    match = _UNIT.fullmatch(term.unit)
    if not _is_said(term) or not written or match is None or match["times"] or match["over"]:
        return
    here, there = unit_size(match["unit"], si), unit_size(written, si)
    if here is not None and there is not None and abs(here[0] - there[0]) > _SAME_SIZE * there[0]:
        insisting = f"{match['sign'] or ''}1*{match['unit']}"
        raise BadInputError(
            f"--column {name}={term.column}:{term.unit}",
            f"contradicts the file, which says {written!r}",
            f"{name}={term.column} for what the file says, or {name}={term.column}:{insisting} to insist",
        )


def _not_there(raw: RawColumns, name: str, source: str) -> BadInputError:
    """The refusal of a column that the file does not have, or has twice."""
    column = source.rpartition(":")[0].strip() or source
    for said in (source, column):
        raw.require_certain(said)
    near = difflib.get_close_matches(column, raw.values, 1)
    hint = f"{near[0]!r}, perhaps; it has" if near else "one of"
    return BadInputError(
        str(raw.path),
        f"has no column {column!r} for {name}",
        f"{hint} {listed(list(raw.values))}{raw.doubt_of_encoding}",
    )


def _summed(raw: RawColumns, name: str, terms: Sequence[Term], si: str) -> Floats:
    """The column in SI units; of a time in several parts, counted from its first row, so that no digit is lost."""
    parts = []
    for term in terms:
        values = raw.values[term.column]
        if term.wrap is not None:
            values = wrapped_on(values, term.wrap, name == TIME or name.endswith((".position", ".position_ref")))
        if name == TIME and len(terms) > 1 and np.isfinite(values).any():
            values = values - values[np.isfinite(values)][0]
        factor, zero = _size(term, name, si, raw.units)
        parts.append(factor * (values - zero))
    total = np.sum(parts, axis=0)
    return total - _midnights(parts) if name == TIME and len(parts) > 1 else np.asarray(total)


def _midnights(parts: Sequence[Floats]) -> Floats:
    """Seconds (n,) that a date and a time of day count twice: where the date goes on by a day, a clock that stands in
    another column was carried on past midnight already.
    """
    good = np.flatnonzero(np.all(np.isfinite(parts), axis=0))
    steps = np.diff(np.asarray(parts)[:, good], axis=1)
    days = np.all(steps % DAY_S == 0.0, axis=1)
    if days.all() or not days.any():
        return np.zeros(len(parts[0]))
    clocks = np.sum(steps[~days], axis=0)
    twice = np.where(np.abs(clocks) < BETWEEN_ROWS_S, np.sum(steps[days], axis=0), 0.0)
    found = np.zeros(len(parts[0]))
    found[good[1:]] = np.cumsum(twice)
    return found


def _size(term: Term, name: str, si: str, stated: Mapping[str, str]) -> tuple[float, float]:
    """Size of what is written in SI units, and what it reads where that is zero."""
    text = term.unit or stated.get(term.column, "")
    if not text and name == TIME:
        text = next((unit for unit, names in _PARTS.items() if names.search(term.column)), "")
    match = _UNIT.fullmatch(text)
    parts = match.groupdict() if match is not None else {}
    unit = parts.get("unit") or (stated.get(term.column) if not _is_said(term) else None)
    found = unit_size(unit or si or "1", si)
    times, over = float(parts.get("times") or 1.0), float(parts.get("over") or 1.0)
    if found is None or times == 0.0 or over == 0.0:
        if "KT" in text:
            # what was printed for a person to fill in
            expected = f"the {si} of one ampere in place of KT, as 0.062*{si}: 8.27 / KV of a motor of KV rpm/V"
            raise BadInputError(f"--column {name}={term.column}:{text}", "KT is to be filled in", expected)
        more = "" if knows_all_units() else "; others with pip install 'gimbal-hil[units]'"
        raise BadInputError(
            f"--column {name}={term.column}" + (f":{term.unit}" if term.unit else ""),
            f"{text!r}{'' if term.unit else ', which the file says,'} is no unit for {name}",
            f"{', '.join(UNITS[si])}{more}; a number may multiply or divide it (2*{si or 1}, {si or 1}/8192), a minus "
            "before it mirrors it",
        )
    sign = -1.0 if parts.get("sign") else 1.0
    return sign * times * found[0] / over, found[1]
