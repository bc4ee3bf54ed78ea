"""Where a number of the model stands in the plant's parameters, read and written in the unit of the model file."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim_backend import layout
from sim_backend.model import NUMBER_AT, AntennaModel, ModelKind, SlotBase, lag_decay

_TIME_CONSTANT = "actuator.time_constant"
#: a lag that moves never quite vanishes: its response stays smooth there
_LEAST_LAG_S, _LEAST_DECAY = 1e-6, 1e-300


def number_slot(model: AntennaModel, axis: str, path: str) -> int:
    """Offset in P of one number of the model; the actuator's time constant answers its decay's slot."""
    index = model.axes.index(axis)
    path = model.number_path(axis, path)
    if path == _TIME_CONSTANT:
        return layout.axis_block(index) + layout.LAG_DECAY
    number = NUMBER_AT[path]
    first = {
        SlotBase.AXIS: layout.axis_block(index),
        SlotBase.INERTIA: (layout.INERTIA_OUTER, layout.INERTIA_INNER)[index],
        SlotBase.COG: (layout.COG_OUTER, layout.COG_INNER)[index],
        SlotBase.MASS: (layout.MASS_OUTER, layout.MASS_INNER)[index],
    }[number.block]
    return first + number.slot


def read_number(model: AntennaModel, P: NDArray[np.float64], axis: str, path: str) -> float:
    """One number as it stands in P."""
    slot = number_slot(model, axis, path)
    if path != _TIME_CONSTANT:
        return float(P[slot])
    # a lag's mean over a step is (1 - decay) tau / h
    mean = float(P[slot + layout.LAG_MEAN - layout.LAG_DECAY])
    return mean * float(P[layout.STEP_S]) / (1.0 - float(P[slot])) if mean > 0.0 else 0.0


def turned_inertia(model: AntennaModel, P: NDArray[np.float64], axis: str) -> float:
    """What a joint has to accelerate, kg m2 or kg: its body, and what an outer one carries in the mean of its poses."""
    own = read_number(model, P, axis, "body.own_inertia")
    if model.kind is not ModelKind.GIMBAL or model.axes.index(axis) == 1:
        return own
    carried = model.axes[1]
    return own + 0.5 * sum(read_number(model, P, carried, f"body.inertia.{one}") for one in ("xx", "zz"))


def write_number(model: AntennaModel, P: NDArray[np.float64], axis: str, path: str, value: float) -> None:
    """Put one number into P."""
    slot = number_slot(model, axis, path)
    if path != _TIME_CONSTANT:
        P[slot] = value
        return
    decay, mean = lag_decay(max(value, _LEAST_LAG_S), float(P[layout.STEP_S]))
    P[slot], P[slot + layout.LAG_MEAN - layout.LAG_DECAY] = max(decay, _LEAST_DECAY), mean
