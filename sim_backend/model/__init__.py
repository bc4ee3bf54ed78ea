"""Model files: read, checked, changed, written, and turned into the plant's arrays."""

from sim_backend.model.arrays import THESIS_BASE_CASES, PlantArrays, base_rows, lag_decay, plant_arrays, put_friction
from sim_backend.model.file import BaseMotionKind, BaseSection, ModelFile, ModelKind, Quantity
from sim_backend.model.formula import dimension_of, unit_text
from sim_backend.model.laws import MOST_ACROSS, UNIT_OF, UNIT_OVER, ActsOn, LawKind, LawProgram, Over, put_variable
from sim_backend.model.model import AntennaModel, EffectEntry, load_model, model_from_document
from sim_backend.model.numbers import (
    CENTRE,
    ENDLESS,
    MOMENTS,
    NUMBER_AT,
    PRODUCTS,
    SlotBase,
    beside,
    gyro_filter,
)
from sim_backend.model.shipped import CONTROL_ANTENNA, model_named, shipped_model, shipped_model_path
from sim_backend.model.tilt import (
    has_weight,
    mass_stands_in,
    position_has_a_zero,
    stands_upright,
    with_weight_left_open,
)

__all__ = [
    "CENTRE",
    "CONTROL_ANTENNA",
    "ENDLESS",
    "MOMENTS",
    "MOST_ACROSS",
    "NUMBER_AT",
    "PRODUCTS",
    "THESIS_BASE_CASES",
    "UNIT_OF",
    "UNIT_OVER",
    "ActsOn",
    "AntennaModel",
    "BaseMotionKind",
    "BaseSection",
    "EffectEntry",
    "LawKind",
    "LawProgram",
    "ModelFile",
    "ModelKind",
    "Over",
    "PlantArrays",
    "Quantity",
    "SlotBase",
    "base_rows",
    "beside",
    "dimension_of",
    "gyro_filter",
    "has_weight",
    "lag_decay",
    "load_model",
    "mass_stands_in",
    "model_from_document",
    "model_named",
    "plant_arrays",
    "position_has_a_zero",
    "put_friction",
    "put_variable",
    "shipped_model",
    "shipped_model_path",
    "stands_upright",
    "unit_text",
    "with_weight_left_open",
]
