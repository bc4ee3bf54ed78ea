"""Noise: what would be left over if the model were perfect, of each channel and of each row."""

from gimbal_hil.knowledge.discrepancy.noise.floors import (
    Floor,
    WideTwin,
    effective_floors,
    encoder_share,
    encoder_squares,
    floors,
    smaller,
    spectral_floors,
    wide_twin,
)
from gimbal_hil.knowledge.discrepancy.noise.processing import processing_floors
from gimbal_hil.knowledge.discrepancy.noise.row_noise import moves, row_scales

__all__ = [
    "Floor",
    "WideTwin",
    "effective_floors",
    "encoder_share",
    "encoder_squares",
    "floors",
    "moves",
    "processing_floors",
    "row_scales",
    "smaller",
    "spectral_floors",
    "wide_twin",
]
