"""The thesis' slips as switches: what the printed equations add to the corrected bias torque.

Only for showing what each slip does (`gimbal-hil experiment thesis`); every model of an antenna has them off.
"""

from __future__ import annotations

from enum import IntFlag

import numpy as np

from firmware_protocol.compiling import compiled

Vector = tuple[float, float, float]


class Slip(IntFlag):
    """The printed forms of ERRATA that can be switched on."""

    NONE = 0


@compiled
def slip_torque(
    P: np.ndarray, K: np.ndarray, q: tuple[float, float], v: tuple[float, float], base: tuple[Vector, Vector, Vector]
) -> tuple[float, float]:
    """Bias torque that the slips in K[SLIPS] add on the two axes, N m."""
    return 0.0, 0.0
