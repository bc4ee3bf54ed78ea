"""One axis of a model and of its records in plain numbers: what effects scale their search by."""

from __future__ import annotations

import numpy as np

from gimbal_hil.knowledge.discrepancy.twin import Record
from sim_backend.effects import SLIDES_M, SLIDES_RAD, TORQUE_SHARES, AxisScale, Need
from sim_backend.model import AntennaModel

#: share of the samples whose rate, or torque, is no exception
_ORDINARY = 0.98


def axis_scale(model: AntennaModel, axis: str, records: tuple[Record, ...]) -> AxisScale:
    """Sizes from the records, numbers from the model."""
    i = model.axes.index(axis)
    torque = np.concatenate([r.torque[:, i] for r in records])
    rate = np.abs(np.concatenate([r.motion[:, 2 + i] for r in records]))
    position = np.concatenate([r.motion[:, i] for r in records])
    numbers = {path: quantity.value for (owner, path), quantity in model.numbers.items() if owner == axis}
    return AxisScale(
        torque_rms=float(np.sqrt(np.mean(torque**2))) or 1.0,
        torque_peak=float(np.abs(torque).max()),
        torque_levels=tuple(float(np.quantile(np.abs(torque), share)) for share in TORQUE_SHARES),
        speed=float(np.quantile(rate, _ORDINARY)) or 1e-6,
        position_low=float(position.min()),
        position_high=float(position.max()),
        numbers=numbers | {"body.own_inertia": numbers[model.own_inertia_path(axis)]},
        is_linear=model.is_linear,
        axis_count=len(model.axes),
        axis_index=i,
        present=present_in(model, axis, records),
        stated={
            (entry.effect.name, parameter.name): entry.value(parameter.name)
            for entry in reversed(model.effects)
            if entry.axis == axis and entry.effect.moves_in_place
            for parameter in entry.effect.parameters
        },
    )


def present_in(model: AntennaModel, axis: str, records: tuple[Record, ...]) -> Need:
    """What the records of an axis have of what effects need."""
    i = model.axes.index(axis)
    torque = np.concatenate([r.torque[:, i] for r in records])
    # logs need not share their zero
    travel = max(float(np.ptp(r.motion[:, i])) for r in records)
    level = max(model.number(axis, path) for path in ("friction.coulomb", "friction.breakaway"))
    # bristles that carry half of what they can show it by how they bend
    pushed = float(np.quantile(np.abs(torque), _ORDINARY)) > 0.5 * level
    there = {
        Need.GYRO: all(r.has_gyro[i] for r in records),
        Need.MOVING_BASE: any(r.moving_base for r in records),
        Need.TEMPERATURE: any(r.has_temperature for r in records),
        Need.TORQUE_REVERSALS: bool(torque.min() < 0.0 < torque.max()),
        Need.SLIDING: pushed or travel > (SLIDES_M if model.is_linear else SLIDES_RAD),
        Need.SECOND_AXIS: any(
            bool(np.ptp(r.motion[:, j]) > 0.0) for r in records for j in range(len(model.axes)) if j != i
        ),
    }
    found = Need.NOTHING
    for need, has in there.items():
        found |= need if has else Need.NOTHING
    return found
