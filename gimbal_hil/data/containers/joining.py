"""Columns of several groups as one table, on the times of one of them."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from firmware_protocol.documents import LARGEST_NUMBER
from firmware_protocol.errors import BadInputError
from gimbal_hil.data.containers.contents import Contents, Floats, SampledGroup

#: so many columns are listed where none is near
_LISTED = 6
#: of a row at least this share has to be known
_LEAST_KNOWN = 0.5


@dataclass(frozen=True)
class Joined:
    """Columns (n,) by name on common times `time_s` (n,), None where the file has none."""

    time_s: Floats | None
    columns: dict[str, Floats]
    notes: tuple[str, ...]


def joined(
    contents: Contents, names: Sequence[str], held: Collection[str] = (), acting: Collection[str] = ()
) -> Joined:
    """The columns `names` on the times of the first of them that is sampled: neither held nor acting.

    Of a column in `held` the last value before each time counts; of one in `acting`, which holds too, its mean until
    the next time, so that its impulse is kept; of another the straight line between its samples. Rows before the first
    and behind the last sample of any of them are left out. Where several groups have the names (episodes), the longest
    counts. Raises BadInputError for a name that the file does not have, and for columns in other rows without times.
    """
    homes = {name: _home(contents, name) for name in names}
    base = homes[next((name for name in names if name not in (*held, *acting)), names[0])]
    notes = list(contents.notes)
    for name, home in homes.items():
        others = sum(name in group.columns for group in contents.groups) - 1
        if others and home is base and name == next(iter(homes)):
            notes.append(f"{home.name} was read, the longest of {others + 1} that have {name}")
    apart = {name: home for name, home in homes.items() if home is not base}
    if not apart:
        return Joined(base.time_s, {name: base.columns[name] for name in names}, tuple(notes))
    if base.time_s is None or any(home.time_s is None for home in apart.values()):
        raise BadInputError(
            str(contents.path), f"has {', '.join(apart)} in other rows than {base.name}, and no times", "one table"
        )
    sampled = {name: _of(home, name) for name, home in apart.items()}
    first = max(times[0] for times, _ in sampled.values())
    last = min(times[-1] for times, _ in sampled.values())
    inside = (base.time_s >= first) & (base.time_s <= last)
    at = base.time_s[inside]
    columns: dict[str, Floats] = {}
    for name in names:
        if name not in apart:
            columns[name] = base.columns[name][inside]
            continue
        times, values = sampled[name]
        if name in acting:
            columns[name] = _mean_until_next(times, values, at)
            notes.append(f"{name}: its mean from each sample of {base.name} to the next, each value held")
        elif name in held:
            columns[name] = values[np.searchsorted(times, at, side="right") - 1]
            notes.append(f"{name}: the last value before each sample of {base.name}")
        else:
            columns[name] = np.interp(at, times, values)
            notes.append(f"{name}: a straight line between its samples at the times of {base.name}")
    left = len(base.time_s) - len(at)
    if left:
        notes.append(f"{left} rows of {base.name} lie outside what the others cover and were left out")
    return Joined(at, columns, tuple(notes))


def column_of(contents: Contents, source: str) -> tuple[str, str]:
    """Column and unit of a source `COLUMN` or `COLUMN:UNIT`; without a unit the one that the file states, else ''."""
    known = {name: group.units.get(name, "") for group in contents.groups for name in group.columns}
    if source in known:
        return source, known[source]
    column, colon, unit = source.rpartition(":")
    return (column.strip(), unit.strip()) if colon and column.strip() in known else (source, "")


def _home(contents: Contents, name: str) -> SampledGroup:
    found = [group for group in contents.groups if name in group.columns]
    if found:
        return max(found, key=lambda group: len(group.columns[name]))
    if any(group.timed_by in (name, name.rpartition(":")[0]) for group in contents.groups if group.timed_by):
        raise BadInputError(
            str(contents.path),
            f"has its times from {name!r} already, in seconds by their step",
            "no unit for this column",
        )
    every = [column for group in contents.groups for column in group.columns]
    near = difflib.get_close_matches(name, every, 3)
    some = near or every[:_LISTED]
    hint = f"{'perhaps' if near else 'one of'} {', '.join(some)}; " if some else ""
    raise BadInputError(
        str(contents.path), f"has no column {name!r}", f"{hint}gimbal-hil check {contents.path} lists all {len(every)}"
    )


def _mean_until_next(times: Floats, values: Floats, at: Floats) -> Floats:
    """Mean of a held signal over [at_k, at_k+1), (n,), of what is known of it; the last row counts what holds there. A
    row of which less than half is known is lost.
    """
    lost = np.isnan(values)
    place = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 1)
    steps = np.diff(at)

    def over_rows(held: Floats) -> Floats:
        area = np.concatenate(([0.0], np.cumsum(held[:-1] * np.diff(times))))
        return np.diff(area[place] + held[place] * (at - times[place]))

    known = over_rows(np.where(lost, 0.0, 1.0))
    means = over_rows(np.where(lost, 0.0, values)) / np.where(known > 0.0, known, 1.0)
    means = np.where(known >= _LEAST_KNOWN * steps, means, np.nan)
    return np.append(np.where(steps > 0.0, means, values[place[:-1]]), values[place[-1:]])


def _of(group: SampledGroup, name: str) -> tuple[Floats, Floats]:
    """Times and values of a column where it holds something, in the order of time: NaN for what nobody measures."""
    assert group.time_s is not None
    values = group.columns[name]
    beyond = np.abs(values) > LARGEST_NUMBER
    good = ~np.isnan(values)
    order = np.argsort(group.time_s[good], kind="stable")
    if np.all(beyond[good]):
        raise BadInputError(group.name, f"has no number in {name}", "a column of numbers")
    return group.time_s[good][order], np.where(beyond, np.nan, values)[good][order]
