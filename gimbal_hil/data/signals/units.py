"""The unit of every column of a signals table."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from gimbal_hil.data.signals.table import BASE_ACCELERATIONS, BASE_ANGLES, BASE_RATES, REPEAT, TIME

_OF_AXIS = {
    "torque": "N m",
    "torque_measured": "N m",
    "torque_known": "N m",
    "torque_sampled": "N m",
    "position": "rad",
    "position_ref": "rad",
    "rate": "rad/s",
    "rate_ref": "rad/s",
    "temperature": "degC",
    "current": "A",
}
_LINEAR = {"N m": "N", "rad": "m", "rad/s": "m/s"}
_OTHER = (
    {TIME: "s", REPEAT: ""}
    | dict.fromkeys(BASE_ANGLES, "rad")
    | dict.fromkeys(BASE_RATES, "rad/s")
    | dict.fromkeys(BASE_ACCELERATIONS, "m/s^2")
)


def unit_of(column: str, linear_axes: Collection[str] = ()) -> str:
    """Unit of a column such as `azimuth.position`; empty for a number without one. Axes that slide are named in
    `linear_axes`.
    """
    if column in _OTHER:
        return _OTHER[column]
    axis, _, signal = column.rpartition(".")
    unit = _OF_AXIS.get(signal, "")
    return _LINEAR.get(unit, unit) if axis in linear_axes else unit


def units_of(columns: Collection[str], linear_axes: Collection[str] = ()) -> Mapping[str, str]:
    """The same for many, by column."""
    return {column: unit_of(column, linear_axes) for column in columns}
