"""Floors of a search: noise, and what no twin can follow. A cause that is taken out may show that they lie lower; they never rise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimbal_hil.discrepancy.floors import Floor, WideTwin, floors, smaller
from gimbal_hil.discrepancy.hypothesis import Hypothesis, parameters_of
from gimbal_hil.discrepancy.record import TORQUE
from gimbal_hil.discrepancy.smoothing import Floats
from gimbal_hil.discrepancy.twin import Twin

#: how exactly a twin can follow another integrator: share of the Coulomb level
_EXACTNESS = 0.0012
#: and where it is a rate: share of its noise
_RATE_EXACTNESS = 0.05


@dataclass
class FallingFloors:
    """Noise of every channel as it is known so far, and what the pipeline leaves of the model itself."""

    twin: Twin
    wide: WideTwin
    noise: list[Floor]
    processing: Floats

    def effective(self) -> Floats:
        """Floors per channel as they are."""
        return effective_floors(self.twin, self.noise, self.processing)

    def under(self, hypothesis: Hypothesis) -> Floats:
        """Floors per channel once a hypothesis is taken out: a cause reaches beyond the scored band and passes for noise there."""
        return effective_floors(self.twin, self._noise_under(hypothesis), self.processing)

    def fall(self, hypothesis: Hypothesis) -> Floats:
        """Take a hypothesis out for good; answers the new floors per channel."""
        self.noise = self._noise_under(hypothesis)
        return self.effective()

    def _noise_under(self, hypothesis: Hypothesis) -> list[Floor]:
        structure, P = parameters_of(self.wide, hypothesis)
        return smaller(self.noise, floors(self.twin, self.wide, structure, P))


def effective_floors(twin: Twin, found: list[Floor], processing: Floats) -> Floats:
    """Noise and what no twin can follow, per channel."""
    out = []
    for floor, channel, process in zip(found, twin.channels, processing, strict=True):
        exactness = _RATE_EXACTNESS * floor.rms
        if channel.signal == TORQUE:
            exactness = _EXACTNESS * twin.model.number(channel.axis, "friction.coulomb")
        out.append(float(np.sqrt(floor.rms**2 + max(exactness, min(process, floor.rms)) ** 2)))
    return np.array(out)
