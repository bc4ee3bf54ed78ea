"""What no body and no friction can be: a model file's numbers held against each other."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np

from firmware_protocol.documents import LARGEST_NUMBER
from firmware_protocol.errors import BadInputError
from sim_backend.model.file import ModelFile, ModelKind, Quantity
from sim_backend.model.numbers import FRICTION_ROW, NUMBER_AT


def check_body(numbers: Mapping[tuple[str, str], Quantity], axis: str, file: ModelFile, where: str) -> None:
    def at(path: str) -> float:
        return numbers[axis, path].value

    if file.kind is ModelKind.LINEAR:
        if at("body.mass") <= 0.0:
            raise BadInputError(f"{where}: axes.{axis}.body.mass", "is missing or not positive", "the moving mass, kg")
        return
    own = "zz" if file.kind is ModelKind.ROTARY or list(file.axes).index(axis) == 0 else "yy"
    if at(f"body.inertia.{own}") <= 0.0:
        raise BadInputError(
            f"{where}: axes.{axis}.body.inertia.{own}",
            "is missing or not positive",
            "the moment about the joint's own axis, kg m2",
        )
    if file.kind is ModelKind.ROTARY:
        return
    xx, yy, zz, xy, xz, yz = (at(f"body.inertia.{k}") for k in ("xx", "yy", "zz", "xy", "xz", "yz"))
    moments = np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    slack = 1e-9 * moments[2]
    if moments[0] < -slack or moments[0] + moments[1] < moments[2] - slack:
        shown = ", ".join(f"{m:.4g}" for m in moments)
        raise BadInputError(
            f"{where}: axes.{axis}.body.inertia",
            f"no body has principal moments {shown} kg m2",
            "positive moments, none above the sum of the others",
        )


def check_friction(numbers: Mapping[tuple[str, str], Quantity], axis: str, where: str) -> None:
    breakaway, coulomb, sigma0 = (
        numbers[axis, f"friction.{name}"].value for name in ("breakaway", "coulomb", "sigma0")
    )
    _check_bristle(breakaway, coulomb, sigma0, f"{where}: axes.{axis}.friction")


def _check_bristle(breakaway: float, coulomb: float, sigma0: float, place: str) -> None:
    """Without a bristle the map may dip towards standstill, as measured rigs do; with one there must be something to
    break away from.
    """
    if sigma0 <= 0.0:
        return
    if coulomb <= 0.0:
        raise BadInputError(f"{place}.coulomb", "must be positive where sigma0 is given", "Tc above 0")
    if breakaway < coulomb:
        raise BadInputError(
            f"{place}.breakaway",
            f"{breakaway:g} is below coulomb {coulomb:g}",
            "break-away at or above Coulomb where sigma0 is given",
        )


def temperature_table(raw: Any, place: str) -> tuple[tuple[float, ...], ...]:
    expected = "rows {temperature, " + ", ".join(FRICTION_ROW) + "}, two to eight, temperature rising"
    if not isinstance(raw, list) or not 2 <= len(raw) <= 8 or not all(isinstance(row, dict) for row in raw):
        raise BadInputError(place, "is no table", expected)
    rows: list[tuple[float, ...]] = []
    for i, row in enumerate(raw):
        if set(row) != {"temperature", *FRICTION_ROW}:
            raise BadInputError(f"{place}.{i}", f"has the keys {', '.join(map(str, row))}", expected)
        if not all(is_number(value) for value in row.values()):
            raise BadInputError(f"{place}.{i}", "holds something that is no number", expected)
        for key in FRICTION_ROW:
            number = NUMBER_AT[f"friction.{key}"]
            if not number.low <= row[key] <= number.high:
                raise BadInputError(
                    f"{place}.{i}.{key}",
                    f"{row[key]:g} is out of bounds",
                    f"{number.low:g} to {number.high:g} {number.unit}",
                )
        _check_bristle(row["breakaway"], row["coulomb"], row["sigma0"], f"{place}.{i}")
        rows.append((float(row["temperature"]), *(float(row[key]) for key in FRICTION_ROW)))
    if any(after[0] <= before[0] for before, after in itertools.pairwise(rows)):
        raise BadInputError(place, "temperatures do not rise", expected)
    return tuple(rows)


def is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST_NUMBER
