"""Figures of a step response."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

#: half width of the band that counts as settled, as a share of the step
SETTLING_BAND = 0.02


@dataclass(frozen=True)
class StepResponse:
    """Overshoot in per cent of the step, settling time (None when it does not settle), mean error of the last fifth."""

    overshoot_percent: float
    settling_s: float | None
    error: float


def step_response(
    time_s: NDArray[np.float64], signal: NDArray[np.float64], start: float, target: float
) -> StepResponse:
    """Figures of a step from `start` to `target` at time 0; `signal` (n,) at `time_s` (n,), both from the step on."""
    size = target - start
    progress = (signal - start) / size
    outside = np.flatnonzero(np.abs(progress - 1.0) > SETTLING_BAND)
    settled = len(outside) == 0 or outside[-1] < len(signal) - 1
    settling = 0.0 if len(outside) == 0 else float(time_s[min(outside[-1] + 1, len(time_s) - 1)])
    tail = signal[-max(1, len(signal) // 5) :]
    return StepResponse(
        max(0.0, 100.0 * (float(progress.max()) - 1.0)), settling if settled else None, float(np.mean(tail) - target)
    )
