"""Friction over temperature: runs are grouped by how warm they were, each group is identified by itself, and its
numbers become a row of the model's table.
"""

from __future__ import annotations

import copy
import csv
import io
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.knowledge.identification.axis_identification import AxisIdentification
from gimbal_hil.knowledge.identification.estimate import Determination, Estimate
from gimbal_hil.knowledge.identification.evidence import Log
from gimbal_hil.knowledge.identification.model_update import updated_model
from gimbal_hil.knowledge.identification.stribeck import LUGRE_NAMES
from sim_backend.model import AntennaModel, model_from_document

#: runs within this of each other are of one temperature, and a run may warm up by so much (degC)
SAME_DEGC, MOST_WARMING_DEGC = 6.0, 6.0
#: a table has at most so many rows
MOST_ROWS = 8
#: what an antenna of an aircraft has to work in (degC)
WORKS_FROM_DEGC, WORKS_TO_DEGC = -40.0, 85.0
_TABLE, _AT = "over_temperature", "temperature"
#: a table's plain numbers are those of the row nearest to this (degC)
_ROOM_DEGC = 20.0


@dataclass(frozen=True)
class TemperatureGroup:
    """Logs of one temperature (degC), the mean over all of them and both axes."""

    temperature_degc: float
    logs: tuple[Log, ...]


@dataclass(frozen=True)
class TemperatureResult:
    """What one group's logs said of each axis, and the model that they began from."""

    temperature_degc: float
    prior: AntennaModel
    results: tuple[AxisIdentification, ...]


def has_table(model: AntennaModel) -> bool:
    """Whether any axis' friction follows a table over temperature."""
    return bool(model.friction_over_temperature)


def temperature_of(log: Log, axes: Sequence[str]) -> float:
    """How warm the motors were in a log, degC; BadInputError where it does not tell, or warmed up on the way."""
    told = [log.table.columns[f"{axis}.temperature"] for axis in axes if f"{axis}.temperature" in log.table.columns]
    known = [column[np.isfinite(column)] for column in told]
    known = [column for column in known if len(column)]
    if not known:
        raise BadInputError(f"{log.name}: temperature", "is not told", f"a column {axes[0]}.temperature, degC")
    means = [float(column.mean()) for column in known]
    for axis, column in zip(axes, known, strict=False):
        warmed = float(np.ptp(column))
        if warmed > MOST_WARMING_DEGC:
            problem = f"goes over {warmed:.1f} degrees"
            raise BadInputError(
                f"{log.name}: {axis}.temperature", problem, f"at most {MOST_WARMING_DEGC:g} in a run: let it soak first"
            )
    return float(np.mean(means))


def grouped(logs: Sequence[Log], axes: Sequence[str]) -> tuple[TemperatureGroup, ...]:
    """Logs by temperature, the coldest first; a group ends where the next log is warmer than its first by SAME_DEGC."""
    warm = sorted(((temperature_of(log, axes), place) for place, log in enumerate(logs)))
    found: list[list[tuple[float, int]]] = []
    for one in warm:
        if not found or one[0] - found[-1][0][0] > SAME_DEGC:
            found.append([])
        found[-1].append(one)
    return tuple(
        TemperatureGroup(float(np.mean([t for t, _ in group])), tuple(logs[place] for _, place in group))
        for group in found
    )


def at_temperature(model: AntennaModel, temperature_degc: float) -> AntennaModel:
    """The model with the friction that its tables have at a temperature, and no table."""
    document = copy.deepcopy(model.document)
    for axis in model.friction_over_temperature:
        friction = document["axes"][axis]["friction"]
        rows = friction.pop(_TABLE)
        for name in LUGRE_NAMES:
            value = float(np.interp(temperature_degc, [row[_AT] for row in rows], [row[name] for row in rows]))
            kept = friction.get(name)
            friction[name] = {**kept, "value": value} if isinstance(kept, dict) else value
    return model_from_document(document, model.where)


def as_warm_as(model: AntennaModel, logs: Sequence[Log]) -> AntennaModel:
    """The model with the friction of the mean temperature of these logs; as it is where it has no table."""
    if not has_table(model):
        return model
    return at_temperature(model, float(np.mean([temperature_of(log, model.axes) for log in logs])))


def require_a_table(model: AntennaModel, groups: Sequence[TemperatureGroup]) -> None:
    """BadInputError, before anything is computed, where these runs make no table."""
    known = [row[0] for rows in model.friction_over_temperature.values() for row in rows]
    if len(groups) < 2 and not known:
        (only,) = groups
        raise BadInputError(
            "--over-temperature",
            f"has runs at {only.temperature_degc:.1f} degC alone",
            "runs at two temperatures or more",
        )
    if len(groups) > MOST_ROWS:
        raise BadInputError("--over-temperature", f"has {len(groups)} temperatures", f"at most {MOST_ROWS}")


def with_rows(model: AntennaModel, found: Sequence[TemperatureResult]) -> AntennaModel:
    """The model with a row for each result in the table of every axis, in place of rows within SAME_DEGC of it.

    An axis that was not identified keeps the numbers it had. BadInputError where the table would be too long, or too
    short to be one.
    """
    document = copy.deepcopy(model.document)
    middle = min(found, key=lambda one: abs(one.temperature_degc - _ROOM_DEGC))
    room = updated_model(middle.prior, middle.results).document["axes"]
    for axis in model.axes:
        friction, new = document["axes"][axis].setdefault("friction", {}), [_row(axis, one) for one in found]
        kept = [row for row in friction.get(_TABLE, ()) if all(abs(row[_AT] - one[_AT]) > SAME_DEGC for one in new)]
        rows = sorted([*kept, *new], key=lambda row: float(row[_AT]))
        if not 2 <= len(rows) <= MOST_ROWS:
            raise BadInputError(
                f"{model.where}: axes.{axis}.friction.{_TABLE}",
                f"would have {len(rows)} row(s)",
                f"runs at 2 to {MOST_ROWS} temperatures, more than {SAME_DEGC:g} degrees apart",
            )
        if _TABLE not in friction:
            # where temperature is not known the numbers of a room count, with what they come from
            friction |= {name: room[axis]["friction"][name] for name in LUGRE_NAMES if name in room[axis]["friction"]}
        friction[_TABLE] = rows
    return model_from_document(document, model.where)


def _row(axis: str, one: TemperatureResult) -> dict[str, float]:
    model = updated_model(one.prior, one.results)
    numbers = {name: float(f"{model.number(axis, f'friction.{name}'):.6g}") for name in LUGRE_NAMES}
    return {_AT: round(one.temperature_degc, 1), **numbers}


def table_record(found: Sequence[TemperatureResult]) -> list[Json]:
    """Every number of every row with its interval and verdict, for JSON."""
    return [
        {
            "temperature_degc": one.temperature_degc,
            "axis": result.axis,
            "numbers": {
                e.name: {
                    "value": _plain(e.value),
                    "low": _plain(e.interval.low),
                    "high": _plain(e.interval.high),
                    "unit": e.unit,
                    "verdict": e.verdict.value,
                }
                for e in result.estimates
                if e.name in LUGRE_NAMES
            },
        }
        for one in found
        for result in one.results
    ]


def table_csv(found: Sequence[TemperatureResult]) -> str:
    """The same as a table, a line for each number."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("axis", "temperature_degc", "number", "value", "low", "high", "unit", "verdict"))
    for row in table_record(found):
        for name, one in row["numbers"].items():
            told = (one["value"], one["low"], one["high"], one["unit"], one["verdict"])
            writer.writerow((row["axis"], f"{row['temperature_degc']:.1f}", name, *told))
    return text.getvalue()


def uncovered(found: Sequence[TemperatureResult]) -> str:
    """What of the range that an aircraft's antenna works in no run was in; empty where all is covered."""
    low, high = found[0].temperature_degc, found[-1].temperature_degc
    missing = [f"below {low:.0f}"] if low > WORKS_FROM_DEGC + SAME_DEGC else []
    missing += [f"above {high:.0f}"] if high < WORKS_TO_DEGC - SAME_DEGC else []
    if not missing:
        return ""
    return f"no run {' and none '.join(missing)} degC: there the table holds its last row"


def gaps(found: Sequence[TemperatureResult]) -> list[str]:
    """Neighbouring rows between which viscosity changes by more than half: a straight line is no law there."""
    told = []
    for before, after in itertools.pairwise(found):
        for one, other in zip(before.results, after.results, strict=True):
            low, high = (_estimate(result.estimates, "viscous") for result in (one, other))
            if low and high and min(low, high) > 0.0 and max(low, high) > 1.5 * min(low, high):
                told.append(
                    f"{one.axis}: viscous goes from {low:.4g} to {high:.4g} between {before.temperature_degc:.0f} and "
                    f"{after.temperature_degc:.0f} degC: a run between them would tell how"
                )
    return told


def _estimate(estimates: Sequence[Estimate], name: str) -> float | None:
    return next((e.value for e in estimates if e.name == name and e.verdict is not Determination.NOT_IDENTIFIED), None)


def _plain(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def values_at(found: Sequence[TemperatureResult], axis: str, name: str) -> Mapping[float, Estimate]:
    """Estimates of one number by temperature, those that data determined."""
    return {
        one.temperature_degc: e
        for one in found
        for result in one.results
        if result.axis == axis
        for e in result.estimates
        if e.name == name and e.verdict is not Determination.NOT_IDENTIFIED
    }
