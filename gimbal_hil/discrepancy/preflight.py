"""Can these logs be judged at all? Equal rates, motion, torque, and units that fit the model."""

from __future__ import annotations

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.signals import SignalsTable
from sim_backend.model import AntennaModel

_LEAST_S = 4.0
#: commanded torque against the model's actuator that only another unit explains
_UNITS_RATIO = 60.0
#: torque that the model's inertia alone needs for the measured motion, against the commanded one, both as 0.9 quantiles: degrees give up to 57
_MOTION_RATIO = 12.0


def check_logs(model: AntennaModel, tables: tuple[SignalsTable, ...]) -> None:
    """Raise BadInputError that names log, column and expectation when a log cannot be used."""
    period = tables[0].period_s
    for table in tables:
        where = table.source or "log"
        if abs(table.period_s - period) > 0.01 * period:
            raise BadInputError(where, f"has a period of {table.period_s:.6g} s", f"{period:.6g} s like the first log")
        if len(table) * table.period_s < _LEAST_S:
            raise BadInputError(where, f"lasts {len(table) * table.period_s:.1f} s", f"at least {_LEAST_S:g} s")
        if all(float(np.ptp(table.position(axis))) == 0.0 for axis in model.axes):
            raise BadInputError(f"{where}: position", "never changes", "motion of at least one axis")
        for axis in model.axes:
            _check_units(model, table, axis, where)


def _check_units(model: AntennaModel, table: SignalsTable, axis: str, where: str) -> None:
    limit = model.number(axis, "actuator.limit")
    peak = float(np.abs(table.torque(axis)).max())
    if limit > 0.0 and peak > _UNITS_RATIO * limit:
        raise BadInputError(
            f"{where}: {axis}.torque", f"reaches {peak:.3g}, the model's actuator {limit:.3g}", "torque in N m (force in N)"
        )
    inertia = model.number(axis, model.own_inertia_path(axis))
    step = max(1, int(0.05 / table.period_s))
    q = table.position(axis)[::step]
    if len(q) < 20 or peak == 0.0:
        return
    needed = inertia * np.abs(np.diff(q, n=2)) / (step * table.period_s) ** 2
    usual = float(np.quantile(np.abs(table.torque(axis)), 0.9))
    if float(np.quantile(needed, 0.9)) > _MOTION_RATIO * max(usual, 0.05 * peak):
        raise BadInputError(
            f"{where}: {axis}.position",
            f"needs {float(np.quantile(needed, 0.9)):.3g} for the model's inertia where {usual:.3g} was commanded",
            "SI units (rad, N m or m, N)",
        )  # fmt: skip
