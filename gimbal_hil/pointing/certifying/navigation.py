"""What an inertial navigation gets wrong: constant and wandering errors, noise, an age that it hides, silence."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from firmware_protocol import mail
from firmware_protocol.documents import Strict, read_yaml, validated
from gimbal_hil.realtime.lockstep import ERROR_COLUMNS, SILENT

NotNegative = Annotated[float, Field(ge=0.0)]
#: navigation tells at this rate (Hz)
TOLD_HZ = 100.0
_STEPS = (
    mail.BASE_ATTITUDE_ROLL_STEP,
    mail.BASE_ATTITUDE_PITCH_STEP,
    mail.BASE_HEADING_YAW_STEP,
    mail.BASE_RATE_P_STEP,
    mail.BASE_RATE_Q_STEP,
    mail.BASE_RATE_R_STEP,
)


class NavigationErrors(Strict):
    """One standard deviation each, unless it says otherwise; of a GNSS-aided inertial navigation of an airliner's
    terminal where nothing else is known. Assumed numbers: replace them by those of your unit's data sheet.
    """

    schema_: int = Field(default=1, alias="schema", ge=1, le=1)
    roll_bias_deg: NotNegative = 0.02
    pitch_bias_deg: NotNegative = 0.02
    heading_bias_deg: NotNegative = 0.05
    #: what wanders beside the bias, of each angle, and its correlation time
    wander_deg: NotNegative = 0.01
    wander_s: Annotated[float, Field(gt=0.0)] = 20.0
    #: white, of each angle and each rate as told
    noise_deg: NotNegative = 0.002
    rate_noise_deg_s: NotNegative = 0.02
    #: attitude is older than it says by at most so much, uniformly
    latency_s: Annotated[float, Field(ge=0.0, le=0.05)] = 0.004
    #: times without any attitude: how many an hour, how long from and to (the logarithm uniformly)
    dropouts_per_hour: NotNegative = 30.0
    dropout_s: tuple[Annotated[float, Field(gt=0.0)], Annotated[float, Field(gt=0.0)]] = (0.05, 3.0)

    def drawn(self, duration_s: float, draw: np.random.Generator) -> tuple[NDArray[np.int64], float]:
        """Errors (n, ERROR_COLUMNS) in steps of the wire at TOLD_HZ: roll, pitch, yaw, p, q, r, and whether navigation
        is silent; and the age (s) that it does not tell.
        """
        rows = math.ceil(duration_s * TOLD_HZ) + 1
        biases = np.radians((self.roll_bias_deg, self.pitch_bias_deg, self.heading_bias_deg)) * draw.standard_normal(3)
        angles = biases + math.radians(self.wander_deg) * _wander(rows, self.wander_s, draw)
        angles += math.radians(self.noise_deg) * draw.standard_normal((rows, 3))
        rates = math.radians(self.rate_noise_deg_s) * draw.standard_normal((rows, 3))
        found = np.zeros((rows, ERROR_COLUMNS), dtype=np.int64)
        found[:, :6] = np.round(np.column_stack([angles, rates]) / _STEPS)
        low, high = np.log(self.dropout_s)
        for _ in range(draw.poisson(self.dropouts_per_hour * duration_s / 3600.0)):
            begins, lasts_s = draw.uniform(0.0, duration_s), math.exp(draw.uniform(low, high))
            found[round(begins * TOLD_HZ) : round((begins + lasts_s) * TOLD_HZ) + 1, SILENT] = 1
        return found, float(draw.uniform(0.0, self.latency_s))


def _wander(rows: int, time_s: float, draw: np.random.Generator) -> NDArray[np.float64]:
    """Unit Gauss-Markov processes (rows, 3) of a correlation time, in their steady state."""
    from scipy.signal import lfilter

    keeps = math.exp(-1.0 / (TOLD_HZ * time_s))
    noise = draw.standard_normal((rows, 3)) * math.sqrt(1.0 - keeps**2)
    noise[0] /= math.sqrt(1.0 - keeps**2)
    return np.asarray(lfilter([1.0], [1.0, -keeps], noise, axis=0))


def load_navigation(path: Path) -> NavigationErrors:
    """Errors from a file; BadInputError names file, key and what was expected."""
    document = read_yaml(path, "a file with errors of a navigation, such as roll_bias_deg")
    return validated(NavigationErrors, document, str(path))
