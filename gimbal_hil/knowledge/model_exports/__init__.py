"""A model for other people's simulators, with an account of what their format cannot hold."""

from gimbal_hil.knowledge.model_exports.account import ExportedModel, Item, Remark, items_of
from gimbal_hil.knowledge.model_exports.formats import ModelFormat
from gimbal_hil.knowledge.model_exports.writing import FORMATS, export_model, has_dcmotor

__all__ = ["FORMATS", "ExportedModel", "Item", "ModelFormat", "Remark", "export_model", "has_dcmotor", "items_of"]
