"""What the controller tables imply and the thesis does not print: drive gain, torque limit, tilt of the base, times of
the steps.

Inferred by fitting every table at once. The tilted configuration carries all of them; the level one is the plainer
reading, and fails on the two odd rows of table 5.6.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from gimbal_hil.proof.thesis.printed import Loop
from sim_backend.model import AntennaModel, shipped_model


@dataclass(frozen=True)
class InferredDrive:
    """Torque per controller unit and hard limit, both N m."""

    per_unit_nm: float
    limit_nm: float


@dataclass(frozen=True)
class Configuration:
    """One reading of what the thesis simulated."""

    name: str
    outer: InferredDrive
    inner: InferredDrive
    roll_rad: float
    pitch_rad: float

    def drive(self, axis: str) -> InferredDrive:
        """The drive of an axis."""
        return self.outer if axis == "outer" else self.inner

    def antenna(self) -> AntennaModel:
        """The thesis' antenna on this base, with these limits, and with ideal sensors."""
        attitude = {"roll": self.roll_rad, "pitch": self.pitch_rad}
        model = ideal_sensors(shipped_model()).with_base({"motion": "fixed", "attitude_rad": attitude})
        for axis in model.axes:
            model = model.with_number(axis, "actuator.limit", self.drive(axis).limit_nm)
        return model


def ideal_sensors(model: AntennaModel) -> AntennaModel:
    """A model whose encoder and gyro have neither steps nor noise."""
    for axis in model.axes:
        for path in ("encoder.step", "gyro.noise", "gyro.step"):
            model = model.with_number(axis, path, 0.0)
    return model


TILTED = Configuration(
    "tilted base", InferredDrive(2.84, 14.98), InferredDrive(2.1, 6.6), math.radians(-7.2), math.radians(-9.6)
)
LEVEL = Configuration("level base", InferredDrive(2.5, 15.5), InferredDrive(2.1, 6.6), 0.0, 0.0)

#: when the step comes; settling counts from t = 0, to a band of 2 %
STEP_TIME_S = {
    (Loop.RATE, "outer"): 0.20,
    (Loop.RATE, "inner"): 0.20,
    (Loop.POSITION, "outer"): 0.11,
    (Loop.POSITION, "inner"): 0.28,
}
SETTLING_BAND = 0.02
