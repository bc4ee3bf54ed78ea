"""Other ways to read a log: each misreading that people make, as the change of the table that would undo it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import chain, combinations

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.data.signals import RigidBody, SignalsTable
from sim_backend.model import AntennaModel, ModelKind

Floats = NDArray[np.float64]

MIRRORED, SWAPPED, TURNS = "mirrored", "swapped", "in turns"
_RADIANS = float(np.deg2rad(1.0))
#: motion is smoothed over this long, s
_SMOOTHING_S = 0.05
#: a step of this share of a column's range goes across it
_ACROSS = 0.9
_ANGLES, _RATES = ("base.roll", "base.pitch", "base.yaw"), ("base.p", "base.q", "base.r")


@dataclass(frozen=True)
class OtherReading:
    """`columns` are `what` (in words that follow "is" or "are"); `undone` is the table as it should have been, `remedy`
    what to do. One `of_rows` is undone on the rows of a log, before their means are taken.
    """

    columns: tuple[str, ...]
    what: str
    remedy: str
    undone: Callable[[SignalsTable], SignalsTable]
    of_rows: bool = False
    #: what each column would be said to be in, where that would do
    units: Mapping[str, str] = field(default_factory=dict)


def other_readings(
    model: AntennaModel, tables: tuple[SignalsTable, ...], rows: tuple[SignalsTable, ...]
) -> Iterator[OtherReading]:
    """Every misreading that these tables allow, with one unit or sign wrong at a time; `rows` are the tables before
    means of their rows were taken.
    """
    present = set.intersection(*(set(table.columns) for table in tables))
    rotary = model.kind is not ModelKind.LINEAR
    joints = [
        tuple(some) for some in (*([axis] for axis in model.axes), *([model.axes] if len(model.axes) > 1 else []))
    ]
    for axes in joints:
        for signals in _some_of(("position", "rate")):
            columns = tuple(f"{axis}.{signal}" for axis in axes for signal in signals)
            if set(columns) <= present and rotary:
                for what, size, unit in (("in degrees", _RADIANS, "deg"), (TURNS, 2.0 * np.pi, "turn")):
                    units = _units(columns, unit, f"{unit}/s")
                    yield OtherReading(columns, what, "radians (and rad/s)", _scaled(columns, size), units=units)
            elif set(columns) <= present:
                undone, units = _scaled(columns, 1e-3), _units(columns, "mm", "mm/s")
                yield OtherReading(columns, "in millimetres", "metres (and m/s)", undone, units=units)
    for axis in model.axes:
        for signals in (*_some_of(("position", "rate")), ("torque",)):
            columns = tuple(f"{axis}.{signal}" for signal in signals)
            if set(columns) <= present:
                remedy = "one positive direction for torque, position and rate of an axis"
                si = ("-rad", "-rad/s", "-N m") if rotary else ("-m", "-m/s", "-N")
                yield OtherReading(columns, MIRRORED, remedy, _scaled(columns, -1.0), units=_units(columns, *si))
    for axis in model.axes:
        if all(_keeps_its_sign(table.torque(axis)) for table in tables):
            remedy = "a torque that is negative where it acts the other way"
            yield OtherReading((f"{axis}.torque",), "without its sign", remedy, _signed(model, axis))
    for axis in model.axes:
        if all(_jumps_across(table.commanded(axis)) for table in rows):
            remedy = f"{axis}.torque (or .current)=COLUMN%WRAP:UNIT in --column, WRAP as 256 of 8 bits"
            what = "of a number that begins again at the other end of its range"
            yield OtherReading((f"{axis}.torque",), what, remedy, _carried_on(f"{axis}.torque"), of_rows=True)
    if len(model.axes) == 2:
        for signals in _some_of(("torque", "position", "rate")):
            columns = tuple(f"{axis}.{signal}" for axis in model.axes for signal in signals)
            if set(columns) <= present:
                yield OtherReading(
                    columns, SWAPPED, "the columns of each axis under its own name", _swapped(model.axes, signals)
                )
    for groups in _some_of((_ANGLES, _RATES)):
        columns = tuple(name for group in groups for name in group if name in present)
        if columns and all(any(name in present for name in group) for group in groups):
            units = {name: "deg" if name in _ANGLES else "deg/s" for name in columns}
            yield OtherReading(columns, "in degrees", "radians and rad/s", _scaled(columns, _RADIANS), units=units)
    yield OtherReading(("time_s",), "in milliseconds", "seconds", _in_seconds, units={"time_s": "ms"})


def in_amperes(per_ampere: Mapping[str, float], unit: str, whole: tuple[str, ...] = ()) -> OtherReading:
    """Torque columns that hold a current, of which one ampere makes about so much on each of these axes; or another
    unit of position, which whole numbers in all rows of these axes are for certain.
    """
    columns = tuple(f"{axis}.torque" for axis in per_ampere)
    about = ", ".join(f"{gain:.1g} {unit}/A on {axis}" for axis, gain in per_ampere.items())
    remedy = f"columns AXIS.current and actuator.torque_constant in the model (about {about}?)"
    if whole:
        counts = " ".join(f"{axis}.position=COLUMN:turn/COUNTS" for axis in whole)
        remedy = f"--column {counts} with the counts of a turn, since its positions are whole numbers; or {remedy}"
    elif unit == "N m":
        remedy += ", or positions in radians, which turns, counts or the motor's side of a gear are not"

    def undone(table: SignalsTable) -> SignalsTable:
        return _with(table, {f"{axis}.torque": gain * table.torque(axis) for axis, gain in per_ampere.items()})

    return OtherReading(columns, "in amperes or another unit than torque's", remedy, undone)


def _some_of(parts: tuple) -> list[tuple]:
    """Every choice of parts, the whole first."""
    return list(chain.from_iterable(combinations(parts, count) for count in range(len(parts), 0, -1)))


def _with(table: SignalsTable, changed: dict) -> SignalsTable:
    return table.but(changed)


def _units(columns: tuple[str, ...], position: str, rate: str, torque: str = "") -> dict[str, str]:
    """The unit of each of these columns of axes."""
    by_signal = {"position": position, "rate": rate, "torque": torque}
    return {name: by_signal[name.rpartition(".")[2]] for name in columns}


def _scaled(columns: tuple[str, ...], factor: float) -> Callable[[SignalsTable], SignalsTable]:
    return lambda table: _with(table, {name: factor * table.columns[name] for name in columns})


def _swapped(axes: tuple[str, ...], signals: tuple[str, ...]) -> Callable[[SignalsTable], SignalsTable]:
    one, other = axes
    pairs = [(f"{a}.{signal}", f"{b}.{signal}") for a, b in ((one, other), (other, one)) for signal in signals]
    return lambda table: _with(table, {to: table.columns[of] for to, of in pairs})


def _keeps_its_sign(torque: Floats) -> bool:
    return bool(np.ptp(torque) > 0.0 and (np.all(torque >= 0.0) or np.all(torque <= 0.0)))


def _jumps_across(torque: Floats) -> bool:
    """Whether a torque goes from one end of its range to the other between two rows, as a drive of two levels does
    too.
    """
    return bool(np.ptp(torque) > 0.0 and np.max(np.abs(np.diff(torque))) > _ACROSS * np.ptp(torque))


def _carried_on(column: str) -> Callable[[SignalsTable], SignalsTable]:
    """The column carried on where it begins again, after its whole range and the step that it is counted in."""

    def undone(table: SignalsTable) -> SignalsTable:
        values = table.columns[column]
        steps = np.diff(np.unique(values))
        whole = float(np.ptp(values)) + (float(steps.min()) if len(steps) else 0.0)
        return _with(table, {column: np.unwrap(values, period=whole)})

    return undone


def _signed(model: AntennaModel, axis: str) -> Callable[[SignalsTable], SignalsTable]:
    """The torque with the sign of what the model asks for."""

    def undone(table: SignalsTable) -> SignalsTable:
        from scipy.ndimage import gaussian_filter1d

        width = max(1.0, _SMOOTHING_S / table.period_s)
        measured = np.column_stack([table.position(name) for name in model.axes])
        position, rate, bend = (
            np.asarray(gaussian_filter1d(measured, width, axis=0, order=order)) / table.period_s**order
            for order in (0, 1, 2)
        )
        body, index = RigidBody(model).along(table, position, rate), model.axes.index(axis)
        friction = model.number(axis, "friction.coulomb") * np.sign(rate[:, index])
        friction = friction + model.number(axis, "friction.viscous") * rate[:, index]
        asked = body.inertial(bend)[:, index] - body.bias[:, index] + friction
        return _with(table, {f"{axis}.torque": np.abs(table.torque(axis)) * np.sign(asked)})

    return undone


def _in_seconds(table: SignalsTable) -> SignalsTable:
    return SignalsTable.of(table.axes, 1e-3 * table.time_s, table.columns, table.repeat, table.source, table.notes)
