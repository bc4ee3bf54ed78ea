"""A container of somebody else as raw columns: those that are asked for, on the times of the position."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.data.containers import Contents, column_of, contents_of, joined
from gimbal_hil.data.signals.column_map import ColumnMap
from gimbal_hil.data.signals.form import AxisNames
from gimbal_hil.data.signals.source_terms import terms_of, without_time
from gimbal_hil.data.signals.table import HELD_SIGNALS, REPEAT, TIME, column_names
from gimbal_hil.data.tables import RawColumns


@dataclass(frozen=True)
class ContainerColumns:
    """Columns of a container as they are there, what they are called with the units that the file states, and notes."""

    raw: RawColumns
    called: ColumnMap
    notes: tuple[str, ...]


def read_container(path: Path, named: AxisNames, columns: ColumnMap) -> ContainerColumns | None:
    """The columns of `columns`, else those that have names of a signals table, else all of the largest group; None for
    a file that is no container.

    Raises BadInputError as `contents_of` and `joined` do.
    """
    contents = contents_of(path)
    if contents is None:
        return None
    its_own = {group.timed_by for group in contents.groups if group.timed_by}
    if not any(TIME in group.columns for group in contents.groups):
        its_own.add(TIME)
    if columns.sources.get(TIME, "") in its_own:
        # named by what the file calls it, or by what it is here: its times come from the file
        columns = ColumnMap({name: source for name, source in columns.sources.items() if name != TIME})
    called = columns if columns.sources else ColumnMap(_by_their_own_names(contents, named))
    known = tuple(dict.fromkeys(name for group in contents.groups for name in group.columns))
    units = {name: unit for group in contents.groups for name, unit in group.units.items()}
    split = {name: _columns_of(contents, source, known) for name, source in called.sources.items()}
    if not split:
        largest = max(contents.groups, key=lambda group: len(next(iter(group.columns.values()))))
        times = {} if largest.time_s is None else {TIME: largest.time_s}
        return ContainerColumns(_raw(path, times | dict(largest.columns), {}), columns, contents.notes)
    held = {one for name, found in split.items() if name.rpartition(".")[2] in HELD_SIGNALS for one in found}
    acting = {one for name, found in split.items() if name.rpartition(".")[2] in ("torque", "current") for one in found}
    wanted = tuple(dict.fromkeys(one for found in split.values() for one in found))
    together = joined(contents, wanted, held - acting, acting)
    times = {} if together.time_s is None or TIME in split else {TIME: together.time_s}
    return ContainerColumns(_raw(path, times | together.columns, units), called, together.notes)


def _columns_of(contents: Contents, source: str, known: tuple[str, ...]) -> tuple[str, ...]:
    source = without_time(source, known)[0]
    terms = terms_of(source, known, numbered=False)
    return (column_of(contents, source)[0],) if terms is None else tuple(term.column for term in terms)


def _by_their_own_names(contents: Contents, named: AxisNames) -> dict[str, str]:
    present = {name for group in contents.groups for name in group.columns}
    return {name: name for name in (REPEAT, *column_names(named.axes)) if name in present}


def _raw(path: Path, values: dict[str, NDArray[np.float64]], units: dict[str, str]) -> RawColumns:
    finite = {name: np.where(np.isfinite(column), column, np.nan) for name, column in values.items()}
    stated = {name: unit for name, unit in units.items() if name in finite}
    # its rows are counted as where their motion is questioned
    return RawColumns(path, finite, {name: {} for name in finite}, first_row=1, units=stated)
