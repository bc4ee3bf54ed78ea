"""Can these logs be judged together? One rate, motion, length, no copies; what is misread is another check
(`gimbal_hil.preflight`).
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.signals import SignalsTable
from sim_backend.model import AntennaModel

_LEAST_S = 1.5
#: scored bands end no lower, Hz, and no lower and no higher than these over the period: noise is read above them, in
#: bins of a spectrum
_LOWEST_BAND_HZ, _NARROWEST_BAND, _WIDEST_BAND = 1.0, 0.005, 0.1
#: rows of the stretches by which a copy is known, and the share of those of a log that another one may hold too
_STRETCH_ROWS, _MOST_COPIED = 32, 0.25
#: torque that was commanded against what the model's actuator gives
_MOST_TORQUE = 60.0


def check_logs(model: AntennaModel, tables: tuple[SignalsTable, ...], band_hz: float | None = None) -> None:
    """Raise BadInputError that names log, column and expectation when a log cannot be used, or not in a band that ends
    at `band_hz`.
    """
    period = tables[0].period_s
    lowest = max(_LOWEST_BAND_HZ, _NARROWEST_BAND / period)
    if band_hz is not None and not lowest <= band_hz <= _WIDEST_BAND / period:
        expected = f"{lowest:g} to {_WIDEST_BAND / period:g} Hz for rows every {period:g} s"
        raise BadInputError(f"--band {band_hz:g}", "is a band that these logs do not hold", expected)
    check_alike(tables)
    for table in tables:
        where = table.source or "log"
        if abs(table.period_s - period) > 0.01 * period:
            raise BadInputError(where, f"has a period of {table.period_s:.6g} s", f"{period:.6g} s like the first log")
        if len(table) * table.period_s < _LEAST_S:
            raise BadInputError(where, f"lasts {len(table) * table.period_s:.1f} s", f"at least {_LEAST_S:g} s")
        if all(float(np.ptp(table.position(axis))) == 0.0 for axis in model.axes):
            raise BadInputError(f"{where}: position", "never changes", "motion of at least one axis")
        for axis in model.axes:
            check_actuator(model, table, axis, where)


def check_alike(tables: tuple[SignalsTable, ...]) -> None:
    """Raise BadInputError where a log is given twice, or a piece of it as another one: a copy judges nothing."""
    for i, table in enumerate(tables):
        for other in tables[:i]:
            if tuple(table.axes) == tuple(other.axes) and _share_of_copies(table, other) > _MOST_COPIED:
                raise BadInputError(
                    table.source or "log",
                    f"holds the same rows as {other.source or 'another log'}",
                    "another log, of another trajectory",
                )


def _share_of_copies(one: SignalsTable, other: SignalsTable) -> float:
    """Share of the stretches of the shorter log, of those in which it moves, that the longer one holds too, to the
    bit.
    """
    short, long = sorted((_stretches(one), _stretches(other)), key=len)
    return float(np.mean(np.isin(short, long))) if len(short) else 0.0


def _stretches(table: SignalsTable) -> NDArray[np.uint64]:
    """A number for every stretch of rows in which something changes most of the time, if there is any: the same number
    for the same values.
    """
    values = np.column_stack([part(axis) for axis in table.axes for part in (table.position, table.torque)])
    bits = np.ascontiguousarray(values, dtype=float).view(np.uint64)
    weights = np.random.default_rng(0).integers(1, 2**63, (_STRETCH_ROWS, bits.shape[1]), dtype=np.uint64) * 2 + 1
    rows = max(0, len(bits) - _STRETCH_ROWS + 1)
    found = np.zeros(rows, np.uint64)
    for k, row in enumerate(weights):
        found += bits[k : k + rows] @ row
    changes = np.concatenate([[False], np.any(bits[1:] != bits[:-1], axis=1)])
    alive = sliding_window_view(changes, _STRETCH_ROWS).sum(axis=1) > _STRETCH_ROWS // 2 if rows else changes[:0]
    return np.asarray(found[alive] if alive.any() else found)


def check_actuator(model: AntennaModel, table: SignalsTable, axis: str, where: str) -> None:
    """Raise BadInputError where a command is far beyond anything that the model's actuator gives."""
    limit = model.number(axis, "actuator.limit")
    peak = float(np.abs(table.torque(axis)).max())
    if limit > 0.0 and peak > _MOST_TORQUE * limit:
        raise BadInputError(
            f"{where}: {axis}.torque",
            f"reaches {peak:.3g}, the model's actuator {limit:.3g}",
            "torque in N m (force in N)",
        )
