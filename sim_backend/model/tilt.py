"""How the axis of a model lies, and whether a weight on it says where its position is zero."""

from __future__ import annotations

from firmware_protocol.documents import copied
from sim_backend.effects import Variable
from sim_backend.model.file import ModelKind
from sim_backend.model.model import AntennaModel, model_from_document


def stands_upright(model: AntennaModel) -> bool:
    """Whether the one axis of a model is vertical, where no weight acts."""
    return model.kind is ModelKind.ROTARY and model.file.incline_sine == 0.0


def with_tilt_left_open(model: AntennaModel) -> AntennaModel:
    """The model of a single rotary axis with the axis level, where its file does not say how the axis lies and has no
    weight off it; else the model itself. It moves as before, and a weight that it lacks may act.
    """
    if model.kind is not ModelKind.ROTARY or "incline_sine" in model.file.model_fields_set:
        return model
    level = model_from_document(copied(model.document) | {"incline_sine": 1.0}, model.where)
    return model if has_weight(level, model.axes[0]) else level


def has_weight(model: AntennaModel, axis: str) -> bool:
    """Whether gravity turns an axis as its position says."""
    off = any(model.number(axis, f"body.cog.{way}") for way in "xy")
    return model.kind is ModelKind.GIMBAL or (model.kind is ModelKind.ROTARY and not stands_upright(model) and off)


def position_has_a_zero(model: AntennaModel, axis: str) -> bool:
    """Whether gravity or an effect of the model says where the position of an axis is zero."""
    own = (entry.effect for entry in model.effects if entry.axis == axis)
    return has_weight(model, axis) or any(Variable.POSITION in effect.acts_through for effect in own)
