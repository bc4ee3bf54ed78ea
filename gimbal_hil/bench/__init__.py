"""Speed figures, each beside a plain reference from the same run, as a ratio with its spread."""

from gimbal_hil.bench.figures import Figure, paired
from gimbal_hil.bench.speed import speed_figures

__all__ = ["Figure", "paired", "speed_figures"]
