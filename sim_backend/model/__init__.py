"""Model files: read, checked, changed, written, and turned into the plant's arrays."""

from sim_backend.model.arrays import PlantArrays, plant_arrays
from sim_backend.model.file import Kind, Motion, Quantity
from sim_backend.model.model import AntennaModel, EffectEntry, load_model, model_from_document
from sim_backend.model.shipped import shipped_model, shipped_model_path

__all__ = [
    "AntennaModel",
    "EffectEntry",
    "Kind",
    "Motion",
    "PlantArrays",
    "Quantity",
    "load_model",
    "model_from_document",
    "plant_arrays",
    "shipped_model",
    "shipped_model_path",
]
