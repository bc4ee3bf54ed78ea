"""A model as plain curves in CSV: what everybody can read, plot or interpolate.

Columns: axis, curve, variable, unit, value, torque, torque_unit. Friction over rate comes from the plant's own law;
effects that act through the position alone from theirs.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from typing import Any

import numpy as np

from gimbal_hil.knowledge.model_exports.account import Account, ExportedModel
from sim_backend.friction import stribeck_level
from sim_backend.model import ENDLESS, AntennaModel, EffectEntry

#: speeds of the friction curve, a share of the Stribeck velocity up to 10 rad/s or m/s
_SPEEDS = 60
_POSITIONS = 721
_HEAD = ("axis", "curve", "variable", "unit", "value", "torque", "torque_unit")
_CURVES = ("coulomb", "breakaway", "stribeck_velocity", "shape", "viscous")

#: torque over position of an effect, N m or N
_OVER_POSITION: dict[str, Callable[[EffectEntry, np.ndarray], np.ndarray]] = {
    "cogging": lambda one, q: one.value("amplitude") * np.sin(one.value("order") * q + one.value("phase")),
    "cable_spring": lambda one, q: -one.value("stiffness") * (q - one.value("rest_position")),
}
_OVER_RATE: dict[str, Callable[[EffectEntry, np.ndarray], np.ndarray]] = {
    "quadratic_drag": lambda one, v: -one.value("coefficient") * v * np.abs(v),
    "back_emf": lambda one, v: -one.value("coefficient") * v,
}


def curves_of(model: AntennaModel) -> ExportedModel:
    """Rows of all curves of a model; torques as they act on the joint, so friction is negative at positive rates."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_HEAD)
    held: set[tuple[str, str]] = set()
    angle, rate, torque = ("m", "m/s", "N") if model.is_linear else ("rad", "rad/s", "N m")
    for axis in model.axes:
        speeds = _speeds(model, axis)
        _rows(writer, axis, "friction", ("rate", rate, torque), speeds, _friction(model, axis, speeds))
        held |= {(axis, f"friction.{name}") for name in _CURVES}
        for entry in (entry for entry in model.effects if entry.axis == axis):
            name = entry.effect.name
            if name in _OVER_POSITION:
                q = np.linspace(*_span(model, axis), _POSITIONS)
                _rows(writer, axis, name, ("position", angle, torque), q, _OVER_POSITION[name](entry, q))
            elif name in _OVER_RATE:
                _rows(writer, axis, name, ("rate", rate, torque), speeds, _OVER_RATE[name](entry, speeds))
            else:
                continue
            held.add((axis, name))
    return Account(frozenset(held), {}, {}, "it is no curve over position or rate").settle(model, text.getvalue())


def _rows(writer: Any, axis: str, name: str, words: tuple[str, str, str], x: np.ndarray, y: np.ndarray) -> None:
    variable, unit, torque = words
    for one, value in zip(x, y, strict=True):
        writer.writerow((axis, name, variable, unit, f"{one:.9g}", f"{value:.9g}", torque))


def _span(model: AntennaModel, axis: str) -> tuple[float, float]:
    low, high = model.number(axis, "travel.low"), model.number(axis, "travel.high")
    return (low, high) if low > -ENDLESS and high < ENDLESS else (-np.pi, np.pi)


def _speeds(model: AntennaModel, axis: str) -> np.ndarray:
    slowest = 0.01 * model.number(axis, "friction.stribeck_velocity")
    up = np.geomspace(slowest, 10.0, _SPEEDS)
    return np.concatenate([-up[::-1], up])


def _friction(model: AntennaModel, axis: str, speeds: np.ndarray) -> np.ndarray:
    ts, tc, vs, delta, viscous = (
        model.number(axis, f"friction.{k}") for k in ("breakaway", "coulomb", "stribeck_velocity", "shape", "viscous")
    )
    levels = np.array([stribeck_level(abs(float(v)), ts, tc, vs, delta) for v in speeds])
    return -(np.sign(speeds) * levels + viscous * speeds)
