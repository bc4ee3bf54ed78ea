"""What a person writes behind `--column` so that a log is read as it was meant: where a counter begins again, units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from gimbal_hil.data.containers import command_line
from gimbal_hil.data.preflight.impossible import ColumnFault, Floats, Impossible, median_around, scatter_of
from gimbal_hil.data.preflight.position_rows import impossible_positions
from gimbal_hil.data.preflight.torque_rows import impossible_torques
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.data.tables import FileColumn
from sim_backend.model import AntennaModel

#: bits of numbers that begin again
_BITS = (8, 10, 12, 14, 15, 16, 20, 24, 31, 32)
#: a count after which a column begins again is known from its jumps to so many times their scatter, and counts
_SCATTERS, _COUNTS = 3.0, 2.0
#: fewer jumps than this have no scatter of their own, and one alone may be a restart unless it is of so many bits
_FEWEST, _DIGITS = 3, 3
#: all but this share of the jumps are of one size, to so many times the log's scatter and this share of it
_ALMOST_ALL, _EACH, _ALIKE = 0.9, 12.0, 0.1
#: of numbers without their sign so much is left of the largest when they have it
_LEFT = 0.5


def stated_wrap(model: AntennaModel, table: SignalsTable, one: Impossible) -> str:
    """The option that carries a column on where it begins again, as a shell takes it; empty where none that was tried
    mends it.
    """
    column, axis = one.column, one.column.rpartition(".")[0]
    current = f"{axis}.current"
    source = current if column not in table.origins and current in table.origins else column
    origin = table.origins.get(source, FileColumn(column) if table.lines is not None else None)
    if origin is None or one.fault not in (ColumnFault.JUMP, ColumnFault.UNSIGNED):
        return ""
    size = origin.size * (model.number(axis, "actuator.torque_constant") if source == current else 1.0)
    if size == 0.0 or (source == current and not column.endswith(".torque")):
        return ""
    counts, jumps = table.columns[column] / size, one.fault is ColumnFault.JUMP
    turn = 2.0 * np.pi / abs(size) if jumps and not model.is_linear else None
    for wrap in _after(counts, one.rows[0], turn) if jumps else _ranges(counts):
        carried = _carried_on(counts, wrap, jumps)
        mended = table.but({column: size * carried})
        look = impossible_positions if jumps else impossible_torques
        within = jumps or float(np.max(np.abs(carried))) < _LEFT * float(np.max(np.abs(counts)))
        if within and all(found.can_be_made_up for found in look(model, mended, axis)):
            unit = f":{origin.unit}" if origin.unit else ""
            return command_line([f"{source}={origin.name}%{_written(wrap)}{unit}"])
    return ""


def stated_unit(table: SignalsTable, units: Mapping[str, str]) -> str:
    """The option that reads columns in other units, by column, `-` for mirrored ones; empty where a unit was said."""
    words = []
    for name, unit in units.items():
        origin = table.origins.get(name, FileColumn(name))
        if origin.unit:
            return ""
        words.append(f"{name}={origin.name}:{unit}")
    return command_line(words) if words else ""


def _after(counts: Floats, row: int, turn: float | None) -> Iterator[float]:
    """Counts after which a column that jumps into this row begins again, the likeliest first: a number of so many bits,
    else one of few digits where it begins again several times; neither where the jumps are of many sizes. Last a
    `turn`, whatever a filter made of the sizes: the caller looks whether it mends the column.
    """
    steps = np.diff(counts)
    off = steps - median_around(steps)
    sizes = np.abs(off[np.abs(off) > 0.5 * abs(off[row - 1])])
    own = scatter_of(np.diff(steps))
    scatter = float(np.std(sizes)) if len(sizes) >= _FEWEST else own
    middle = float(np.median(sizes))
    room = _SCATTERS * scatter / np.sqrt(len(sizes)) + _COUNTS * _count_of(counts)
    if float(np.quantile(np.abs(sizes - middle), _ALMOST_ALL)) <= _EACH * own + _ALIKE * middle:
        yield from (float(2**bits) for bits in _BITS if abs(2**bits - middle) <= room)
        if len(sizes) > 1:
            shorter = (float(f"{middle:.{digits}g}") for digits in range(1, _DIGITS + 1))
            yield from (short for short in shorter if short > 0.0 and abs(short - middle) <= room)
    if turn is not None:
        yield turn


def _count_of(counts: Floats) -> float:
    """One, of whole numbers; nothing of others."""
    return 1.0 if np.all(np.abs(counts - np.round(counts)) < 1e-3) else 0.0


def _ranges(counts: Floats) -> Iterator[float]:
    yield from (float(2**bits) for bits in _BITS if 2**bits > float(np.max(counts)))


def _carried_on(counts: Floats, wrap: float, goes_on: bool) -> Floats:
    return np.unwrap(counts, period=wrap) if goes_on else (counts + 0.5 * wrap) % wrap - 0.5 * wrap


def _written(wrap: float) -> str:
    return f"{wrap:.0f}" if abs(wrap - round(wrap)) < 1e-9 * wrap else f"{wrap:.12g}"
