"""How the axis of a model lies, and whether a weight on it says where its position is zero."""

from __future__ import annotations

from firmware_protocol.documents import copied
from sim_backend.effects import Variable
from sim_backend.model.file import ModelKind
from sim_backend.model.model import AntennaModel, model_from_document
from sim_backend.model.uncertainty import DEFAULT_SOURCE

#: stands in for a mass that nobody states, and where it says that it comes from
_NOBODY = "assumed: only its product with a distance counts"
_KILOGRAM = {"value": 1.0, "unit": "kg", "source": _NOBODY, "uncertainty": 0.0}


def stands_upright(model: AntennaModel) -> bool:
    """Whether the one axis of a model is vertical, where no weight acts."""
    return model.kind is ModelKind.ROTARY and model.file.incline_sine == 0.0


def with_weight_left_open(model: AntennaModel) -> AntennaModel:
    """The model of a single rotary axis that a weight may act on: level where its file does not say how the axis lies
    and has no weight off it, and of one kilogram at the axis where it states no mass; else the model itself.

    It moves as before. Of the kilogram only its product with a distance counts.
    """
    if model.kind is not ModelKind.ROTARY:
        return model
    axis, level = model.axes[0], model
    if "incline_sine" not in model.file.model_fields_set:
        level = model_from_document(copied(model.document) | {"incline_sine": 1.0}, model.where)
        if has_weight(level, axis):
            return model
    states_mass = level.numbers[axis, "body.mass"].source != DEFAULT_SOURCE
    if stands_upright(level) or states_mass or has_weight(level, axis):
        # beside the axis a kilogram would be a weight that nobody stated
        return level
    document = copied(level.document)
    section = document["axes"][axis]
    section["body"] = section.get("body", {}) | {"mass": _KILOGRAM}
    return model_from_document(document, model.where)


def mass_stands_in(model: AntennaModel, axis: str) -> bool:
    """Whether the mass of an axis is the kilogram that stands in for one that nobody stated."""
    return model.numbers[axis, "body.mass"].source == _NOBODY


def has_weight(model: AntennaModel, axis: str) -> bool:
    """Whether gravity turns an axis as its position says."""
    off = any(model.number(axis, f"body.cog.{way}") for way in "xy")
    return model.kind is ModelKind.GIMBAL or (model.kind is ModelKind.ROTARY and not stands_upright(model) and off)


def position_has_a_zero(model: AntennaModel, axis: str) -> bool:
    """Whether gravity or an effect of the model says where the position of an axis is zero."""
    own = (entry.effect for entry in model.effects if entry.axis == axis)
    return has_weight(model, axis) or any(Variable.POSITION in effect.acts_through for effect in own)
