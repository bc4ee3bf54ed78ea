"""Can these logs be judged together? One rate, motion, length, no copies; what is misread is another check
(`gimbal_hil.data.preflight`).
"""

from __future__ import annotations

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.inquiry.copies import share_copied
from gimbal_hil.knowledge.discrepancy.inquiry.prepare import scored_band
from sim_backend.model import AntennaModel

#: shortest log, s
LEAST_S = 1.5
#: scored bands end no lower, Hz, and no lower and no higher than these over the period: noise is read above them, in
#: bins of a spectrum
_LOWEST_BAND_HZ, _NARROWEST_BAND, _WIDEST_BAND = 1.0, 0.005, 0.1
#: share of a log that another one may hold too, in one piece
_MOST_COPIED = 0.25
#: torque that was commanded against what the model's actuator gives
_MOST_TORQUE = 60.0


def check_logs(model: AntennaModel, tables: tuple[SignalsTable, ...], band_hz: float | None = None) -> None:
    """Raise BadInputError that names log, column and expectation when a log cannot be used, or not in a band that ends
    at `band_hz`.
    """
    period = tables[0].period_s
    lowest = _lowest_band(period)
    if band_hz is not None and not lowest <= band_hz <= _WIDEST_BAND / period:
        expected = f"{lowest:g} to {_WIDEST_BAND / period:g} Hz for rows every {period:g} s"
        raise BadInputError(f"--band {band_hz:g}", "is not a band of these logs", expected)
    check_alike(tables)
    for table in tables:
        where = table.source or "log"
        if abs(table.period_s - period) > 0.01 * period:
            raise BadInputError(where, f"has a period of {table.period_s:.6g} s", f"{period:.6g} s like the first log")
        if len(table) * table.period_s < LEAST_S:
            raise BadInputError(where, f"lasts {len(table) * table.period_s:.1f} s", f"at least {LEAST_S:g} s")
        if all(float(np.ptp(table.position(axis))) == 0.0 for axis in model.axes):
            raise BadInputError(f"{where}: position", "never changes", "motion of at least one axis")
        for axis in model.axes:
            check_actuator(model, table, axis, where)


def _lowest_band(period_s: float) -> float:
    return max(_LOWEST_BAND_HZ, _NARROWEST_BAND / period_s)


def band_within(tables: tuple[SignalsTable, ...], end_hz: float) -> float:
    """End of a band that these logs can have, Hz, as near to `end_hz` as they allow."""
    period = max(table.period_s for table in tables)
    return min(max(end_hz, _lowest_band(period)), scored_band(tables))


def check_alike(tables: tuple[SignalsTable, ...]) -> None:
    """Raise BadInputError where a log is given twice, or a good part of it as another one: a copy judges nothing."""
    for i, table in enumerate(tables):
        for other in tables[:i]:
            if share_copied(table, other) > _MOST_COPIED:
                raise BadInputError(
                    table.source or "log",
                    f"holds the same rows as {other.source or 'another log'}",
                    "another log, of another trajectory",
                )


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
