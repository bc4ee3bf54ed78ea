"""The question before all others: does the model, within a factor, ask for the torque that was logged, or only if it is
read otherwise?
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.preflight.channels import ChannelEquation, channels_of, in_blocks
from gimbal_hil.data.preflight.energy import impossible_energy
from gimbal_hil.data.preflight.readings import MIRRORED, SWAPPED, TURNS, OtherReading, in_amperes, other_readings
from gimbal_hil.data.preflight.slow_rows import require_fast_rows
from gimbal_hil.data.preflight.stating import stated_unit
from gimbal_hil.data.signals import STATED_RATE, SignalsTable
from sim_backend.model import AntennaModel

#: numbers of a sound model are right within this factor
_FACTOR = 3.0
#: one factor over all numbers, and each of them within a small one of it, is not a wrong model but another unit
_COMMON_LEAST, _COMMON_MOST, _COMMON_STEP, _ALIKE = 2.7, 3e4, 1.15, 1.4
#: gains that leave at most so many times the least do as well
_NEARLY = 1.05
#: a channel is suspect when more than this share of it is left; another reading is right when it leaves no more than
#: these shares of any suspect channel, and of what was left of it
_SUSPECT, _LEFT, _OF_IT = 0.5, 0.4, 0.5
#: other rates than a stated one, in times its period
_RATES = [2.0 ** (0.25 * k) for k in range(-28, 29) if abs(k) > 3]
#: whole numbers that go this far are counts
_COUNTS = 2.0
#: of the rows so few may be within what an actuator gives, where a torque is in another unit
_HARDLY_ANY = 0.05
#: the most that a base is pitched by, rad, and what a table rounds
_MOST_PITCH = 0.5 * np.pi + 1e-3

Misfits = Mapping[str, float]


def preflight(model: AntennaModel, tables: tuple[SignalsTable, ...]) -> None:
    """Raise BadInputError that names files, columns and what they seem to hold where logs fit the model only if they
    are read otherwise.

    A model that is off by a factor of two, or that has no friction, or lacks what the search is to find, is no reason
    to refuse: what counts is that another reading of the same numbers makes sense where this one makes none.
    """
    for table in tables:
        require_fast_rows(table)
    misread = misreading(model, tables)
    if misread is None:
        for table in tables:
            _check_attitude(table)
            _check_energy(model, table)
            _check_torque(model, table)
        return
    found, which = misread
    _require_rate(model, which, found)
    where = ", ".join(dict.fromkeys(table.source or "log" for table in which))
    verb = "seems" if len(found.columns) == 1 else "seem"
    raise BadInputError(
        f"{where}: {', '.join(found.columns)}",
        f"{verb} to be {found.what}: only so do they fit what the model asks of this motion",
        _with_option(found.remedy, which, found.units) + _or_the_rate(found, which),
    )


def _with_option(expected: str, tables: tuple[SignalsTable, ...], units: Mapping[str, str]) -> str:
    """What is expected, with the option that says so where one does for all these tables."""
    options = {stated_unit(table, units) for table in tables}
    option = next(iter(options)) if len(options) == 1 else ""
    return f"{expected}: {option}" if option else expected


def _stated_rates(tables: tuple[SignalsTable, ...]) -> list[str]:
    """What was noted of rows whose rate somebody stated."""
    return [note for table in tables for note in table.notes if STATED_RATE in note]


def _require_rate(model: AntennaModel, tables: tuple[SignalsTable, ...], found: OtherReading) -> None:
    """Raise BadInputError where rows whose rate a person stated fit the model at another one, clearly better than with
    what else was `found`, which it tells too.
    """
    if len(stated := _stated_rates(tables)) < len(tables):
        return

    def left(read: Iterable[SignalsTable]) -> float:
        channels = channels_of(model, tuple(in_blocks(table) for table in read))
        return max((one.misfit(_ALIKE) for one in channels.values()), default=np.inf)

    tried = {times: left(_slower(table, times) for table in tables) for times in _RATES}
    times = min(tried, key=lambda one: tried[one])
    if tried[times] < min(_LEFT, _OF_IT * left(tables), _OF_IT * left(found.undone(table) for table in tables)):
        hertz = float(f"{1.0 / (times * tables[0].period_s):.2g}")
        raise BadInputError(
            ", ".join(dict.fromkeys(table.source or "log" for table in tables)) + ": time_s",
            f"fits what the model asks of this motion where the rows came at about {hertz:g} a second ({stated[0]})",
            "--rate with the rows a second at which they were logged; if that is right, "
            f"{', '.join(found.columns)} {'is' if len(found.columns) == 1 else 'are'} {found.what}: "
            + _with_option(found.remedy, tables, found.units),
        )


def _slower(table: SignalsTable, times: float) -> SignalsTable:
    return SignalsTable.of(table.axes, times * table.time_s, table.columns, None, table.source)


def _or_the_rate(found: OtherReading, tables: tuple[SignalsTable, ...]) -> str:
    """What to doubt as well where a person said how fast the rows came: all rates and accelerations scale with it."""
    if found.what in (MIRRORED, SWAPPED):
        return ""
    stated = _stated_rates(tables)
    return f"; or another --rate, if the rows did not come at the one stated ({stated[0]})" if stated else ""


def _check_attitude(table: SignalsTable) -> None:
    """Raise BadInputError for a base that is pitched by more than a quarter turn, which no pitch is."""
    pitch = table.base("pitch")
    most = 0.0 if pitch is None else float(np.abs(pitch).max())
    if most > _MOST_PITCH:
        raise BadInputError(
            f"{table.source or 'log'}: base.pitch",
            f"reaches {most:.3g}, and no pitch is beyond a quarter turn: it seems to be in degrees",
            "radians, for roll and yaw too, and rad/s for rates",
        )


def _check_energy(model: AntennaModel, table: SignalsTable) -> None:
    """Raise BadInputError for a motion that has far more energy than its torque and weight can have given it."""
    found = impossible_energy(model, table)
    if found is None:
        return
    at = f"row {found.row + 1} at {table.time_s[found.row]:.6g}"
    why = (
        f"up to {at} the axis gains {found.gained:.3g} J, where torque and weight can have given it {found.given:.2g} J"
    )
    unit = found.time_unit
    raise BadInputError(
        f"{table.source or 'log'}: time_s" + ("" if unit else f", {found.axis}.position, {found.axis}.torque"),
        f"{'seems to be in ' + unit if unit else 'seem to be in other units'}: {why}",
        "seconds, or --column time_s=COLUMN:UNIT" if unit else "seconds, radians and N m, or --column NAME=COLUMN:UNIT",
    )


def _check_torque(model: AntennaModel, table: SignalsTable) -> None:
    """Raise BadInputError for a torque that is beyond its actuator in nearly all rows: cut to what the actuator gives,
    it is another one, and fits a motion as such. A loop that asks for more than there is comes back from it.
    """
    for axis in model.axes:
        limit = model.number(axis, "actuator.limit")
        least = float(np.quantile(np.abs(table.commanded(axis)), _HARDLY_ANY))
        if least > limit > 0.0:
            raise BadInputError(
                f"{table.source or 'log'}: {axis}.torque",
                f"is {least:.3g} or more in nearly all rows, and the model's actuator gives {limit:g}: it seems to be "
                "in another unit",
                f"--column {axis}.torque=COLUMN:UNIT, or the actuator's limit in the model",
            )


def misreading(
    model: AntennaModel, tables: tuple[SignalsTable, ...]
) -> tuple[OtherReading, tuple[SignalsTable, ...]] | None:
    """The other reading under which the model asks for what was logged, where as it stands it does not, and the tables
    that are to be read so: all, or one of them. None for sound tables.
    """
    blocks = tuple(map(in_blocks, tables))
    channels = channels_of(model, blocks)
    as_read = {name: channel.misfit(_FACTOR) for name, channel in channels.items()}
    found: list[tuple[float, OtherReading, tuple[SignalsTable, ...]]] = []
    counted = tuple(axis for axis in model.axes if all(_are_whole(table.position(axis)) for table in tables))
    current = _amperes(model, channels, as_read, counted)
    if current or max(as_read.values(), default=0.0) > _SUSPECT:
        one_each = [(k,) for k in range(len(tables))] if len(tables) > 1 else []
        for reading in other_readings(model, blocks, tables):
            undone = tuple(_undone(reading, *pair) for pair in zip(tables, blocks, strict=True))
            for which in (tuple(range(len(tables))), *one_each):
                read = tuple(undone[k] if k in which else block for k, block in enumerate(blocks))
                other = channels_of(model, read)
                left = {name: channel.misfit(_FACTOR) for name, channel in other.items()}
                # of several logs all must be left that were there: one that says nothing any more misfits nowhere
                whole = len(which) == len(tables) or _rows(other) == _rows(channels)
                if whole and _is_right(as_read, left):
                    found.append((_size(left), reading, tuple(tables[k] for k in which)))
    likeliest = min(found, key=lambda one: one[0], default=None)
    for size, reading in current:
        if likeliest is None or size < likeliest[0]:
            turns = likeliest is not None and likeliest[1].what == TURNS
            return (_or_turns(reading, likeliest) if likeliest and turns else reading), tables
    return None if likeliest is None else likeliest[1:]


def _or_turns(current: OtherReading, turns: tuple[float, OtherReading, tuple[SignalsTable, ...]]) -> OtherReading:
    """Torque in another unit, with what to say where positions in turns explain the log as well."""
    _, reading, tables = turns
    said = _with_option(f"{', '.join(reading.columns)} in turns", tables, reading.units)
    return replace(current, remedy=f"{current.remedy}; as likely: {said}")


def likely_units(model: AntennaModel, table: SignalsTable) -> Mapping[str, str]:
    """Units of columns of a table, as `--column` says them, under which it fits the model; empty where it does as it
    stands.
    """
    found = misreading(model, (table,))
    return {} if found is None or found[0].what in (MIRRORED, SWAPPED) else found[0].units


def _undone(reading: OtherReading, table: SignalsTable, blocks: SignalsTable) -> SignalsTable:
    """Means of the rows of a table as the reading says that it should have been."""
    return in_blocks(reading.undone(table)) if reading.of_rows else reading.undone(blocks)


def _rows(channels: Mapping[str, ChannelEquation]) -> dict[str, int]:
    return {name: len(channel.target) for name, channel in channels.items()}


def _is_right(as_read: Misfits, left: Misfits) -> bool:
    return all(
        name in left and left[name] < min(_LEFT, _OF_IT * before)
        if before > _SUSPECT
        else left.get(name, np.inf) < _SUSPECT
        for name, before in as_read.items()
    )


def _amperes(
    model: AntennaModel, channels: Mapping[str, ChannelEquation], others: Misfits, whole: tuple[str, ...]
) -> list[tuple[float, OtherReading]]:
    """Torque in another unit: every part of it off by one factor beyond what gains are off by, on one axis that is
    driven or on each.
    """
    driven = {name: channel for name, channel in channels.items() if name.endswith(".torque")}
    as_read = {name: channel.misfit(_ALIKE) for name, channel in driven.items()}
    left, gains = {**others, **as_read}, {}
    steps = np.arange(np.log(_COMMON_LEAST), np.log(_COMMON_MOST), np.log(_COMMON_STEP))
    for name in (name for name in driven if as_read[name] > _SUSPECT):
        factors = np.array([*-steps, *steps])
        tried = np.array([driven[name].misfit(_ALIKE, float(gain)) for gain in np.exp(factors)])
        # numbers may be off as well, so that many gains do as well: the middle one of them
        alike = factors[tried <= _NEARLY * tried.min()]
        left[name], gains[name.removesuffix(".torque")] = float(tried.min()), float(np.exp(alike.mean()))
        # what numbers that are each off by a factor of their own explain nearly as well is a wrong model, not a unit
        if left[name] > _OF_IT * others[name]:
            return []
    if not gains or not _is_right({**others, **as_read}, left):
        return []
    counted = tuple(axis for axis in whole if axis in gains)
    return [(_size(left), in_amperes(gains, "N" if model.is_linear else "N m", counted))]


def _are_whole(position: NDArray[np.float64]) -> bool:
    """Whether a position that moves is whole numbers in all rows: counts, which no angle in radians is."""
    return bool(np.ptp(position) > _COUNTS and np.all(position == np.round(position)))


def _size(left: Misfits) -> float:
    """How much a reading leaves, over all channels."""
    return float(np.mean(np.log(0.1 + np.array(list(left.values())))))
