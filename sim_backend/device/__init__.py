"""What the antenna's firmware does: drive states, deadman, limits, sensors to raw integers, frames."""

from sim_backend.device.core import device_tick
from sim_backend.device.device import ANSWER_AT, DEVICE_OCTETS, Device, device_block_tick, encode_device_mail
from sim_backend.device.records import DRIVE, Drive
from sim_backend.device.sensing import report_base_attitude, report_base_rate, report_motor, sample
from sim_backend.device.settings import DriveAxisSettings, FirmwareSettings, TravelReaction, settings_to_state
from sim_backend.device.spoiling import Spoilt, spoilt_torque

__all__ = [
    "ANSWER_AT",
    "DEVICE_OCTETS",
    "DRIVE",
    "Device",
    "Drive",
    "DriveAxisSettings",
    "FirmwareSettings",
    "Spoilt",
    "TravelReaction",
    "device_block_tick",
    "device_tick",
    "encode_device_mail",
    "report_base_attitude",
    "report_base_rate",
    "report_motor",
    "sample",
    "settings_to_state",
    "spoilt_torque",
]
