"""Drives of other makes, simulated from their public protocols: what the adapters are tested against."""

from sim_backend.drives.axis import Shaft, SimulatedDrive
from sim_backend.drives.cia402 import PositionGains, SimulatedCia402
from sim_backend.drives.gimbal import SIMULATED, DrivenGimbal
from sim_backend.drives.moteus import SimulatedMoteus
from sim_backend.drives.odrive import SimulatedOdrive
from sim_backend.drives.serving import DriveServer

__all__ = [
    "SIMULATED",
    "DriveServer",
    "DrivenGimbal",
    "PositionGains",
    "Shaft",
    "SimulatedCia402",
    "SimulatedDrive",
    "SimulatedMoteus",
    "SimulatedOdrive",
]
