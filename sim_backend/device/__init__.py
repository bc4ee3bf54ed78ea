"""What the antenna's firmware does: drive states, deadman, limits, sensors to raw integers, frames."""

from sim_backend.device.core import device_tick
from sim_backend.device.device import Device, encode_device_mail
from sim_backend.device.records import DRIVE
from sim_backend.device.settings import DriveAxisSettings, FirmwareSettings, TravelReaction, settings_to_state
from sim_backend.device.spoiling import Spoilt

__all__ = [
    "DRIVE",
    "Device",
    "DriveAxisSettings",
    "FirmwareSettings",
    "Spoilt",
    "TravelReaction",
    "device_tick",
    "encode_device_mail",
    "settings_to_state",
]
