"""A gimbal moved by two simulated drives: the model's plant between their shafts and the joints."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from firmware_protocol.adapters import CanFrame
from firmware_protocol.errors import BadInputError
from firmware_protocol.links import AdapterLinkConfig, DriveSection
from sim_backend.drives.axis import SimulatedDrive
from sim_backend.drives.cia402 import SimulatedCia402
from sim_backend.drives.moteus import SimulatedMoteus
from sim_backend.drives.odrive import SimulatedOdrive
from sim_backend.layout import RATE
from sim_backend.model import AntennaModel
from sim_backend.plant import Plant

#: drive -> what simulates one of this section
SIMULATED: dict[str, Callable[[DriveSection], SimulatedDrive]] = {
    "moteus": lambda section: SimulatedMoteus(section.id),
    "odrive": lambda section: SimulatedOdrive(section.id),
    "cia402": lambda section: SimulatedCia402(
        section.id, section.rated_torque_nm or 1.0, section.counts_per_turn or 65536.0
    ),
}


class DrivenGimbal:
    """Two drives and what they move; `hear` at any time, `tick` once a period."""

    def __init__(
        self,
        model: AntennaModel,
        drives: Sequence[SimulatedDrive],
        sections: Sequence[DriveSection],
        rate_hz: float,
        seed: int = 0,
    ) -> None:
        self.model, self.drives, self._sections = model, tuple(drives), tuple(sections)
        self.plant, self._period_s = Plant(model, rate_hz, seed), 1.0 / rate_hz
        self._steps = [model.number(axis, "encoder.step") for axis in model.axes]
        self._move()

    @classmethod
    def of_link(cls, model: AntennaModel, link: AdapterLinkConfig, seed: int = 0) -> DrivenGimbal:
        """The other end of an adapter link; BadInputError for a drive that is not simulated, or a single axis."""
        if link.drive not in SIMULATED:
            raise BadInputError("link.drive", f"{link.drive} is not simulated", ", ".join(SIMULATED))
        if len(model.axes) != len(link.drives):
            raise BadInputError(f"{model.where}: axes", f"{len(model.axes)} axes", f"{len(link.drives)}, one a drive")
        drives = [SIMULATED[link.drive](section) for section in link.drives]
        return cls(model, drives, link.drives, link.rate_hz, seed)

    def hear(self, frames: Sequence[CanFrame]) -> list[CanFrame]:
        """What the drives answer at once."""
        return [answer for frame in frames for drive in self.drives for answer in drive.hear(frame)]

    def tick(self) -> list[CanFrame]:
        """One period: the plant moves under the drives' torques; what they send by themselves."""
        torques = [
            drive.torque_nm * section.sign * section.gear
            for drive, section in zip(self.drives, self._sections, strict=True)
        ]
        held = [
            min(max(torque, -section.torque_nm), section.torque_nm)
            for torque, section in zip(torques, self._sections, strict=True)
        ]
        self.plant.run(np.array([held]))
        for drive, section, torque in zip(self.drives, self._sections, held, strict=True):
            drive.shaft.torque_nm = section.sign * torque / section.gear
        self._move()
        return [frame for drive in self.drives for frame in drive.tick(self._period_s)]

    def _move(self) -> None:
        """Shafts where the joints are, to the encoder's step."""
        positions = self.plant.position
        for place, (drive, section) in enumerate(zip(self.drives, self._sections, strict=True)):
            step = self._steps[place]
            joint = round(positions[place] / step) * step if step > 0.0 else float(positions[place])
            drive.shaft.position_rad = section.sign * section.gear * (joint - section.zero_rad)
            drive.shaft.rate_rad_s = section.sign * section.gear * float(self.plant.X[RATE + place])
