"""How the plant's step decides its error: the whole antenna on a moving base, with friction and reversals, at steps
that halve.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gimbal_hil.proof.thesis.inferred import ideal_sensors
from sim_backend.model import AntennaModel, model_from_document, shipped_model
from sim_backend.plant import Plant

STEPS_S = (8e-4, 4e-4, 2e-4, 1e-4, 5e-5)
#: step of the run that the others are compared with
_FINEST_S = 6.25e-6
_DURATION_S = 1.0
_SWAY = {
    "motion": "sinusoid",
    "amplitude_rad": {"roll": 0.1, "pitch": 0.15, "yaw": 0.2},
    "frequency_hz": {"roll": 0.7, "pitch": 0.5, "yaw": 0.3},
}


@dataclass(frozen=True)
class Convergence:
    """Largest position error of both axes after a second, per step, and the order between neighbouring steps."""

    step_s: tuple[float, ...]
    error_rad: tuple[float, ...]

    @property
    def orders(self) -> tuple[float, ...]:
        """log2 of the error's fall for each halved step."""
        pairs = zip(self.error_rad, self.error_rad[1:], strict=False)
        return tuple(math.log2(coarse / fine) for coarse, fine in pairs)


def step_convergence() -> Convergence:
    """Run the shipped antenna at every step and compare where it ends up."""
    model = ideal_sensors(shipped_model()).with_base(_SWAY)
    finest = _end(model, _FINEST_S)
    return Convergence(STEPS_S, tuple(float(np.max(np.abs(_end(model, step) - finest))) for step in STEPS_S))


def _end(model: AntennaModel, step_s: float) -> np.ndarray:
    stepped = model_from_document(model.document | {"plant_step_s": step_s}, model.where)
    plant = Plant(stepped, 1.0 / step_s)
    t = step_s * (np.arange(round(_DURATION_S / step_s)) + 0.5)
    plant.run(np.column_stack([2.0 * np.sin(2.0 * np.pi * t), 1.04 + 0.8 * np.sin(3.0 * np.pi * t)]))
    return plant.position
