"""Who the antenna says it is."""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from firmware_protocol.schema import PROTOCOL_VERSION
from sim_backend.device.records import Drive


@compiled
def report_identity(mail: np.ndarray, drive: Drive) -> None:
    """Put the protocol's version, the name's code and the brakes into the mail."""
    mail[m.IDENTITY] = 1
    mail[m.IDENTITY_PROTOCOL_VERSION], mail[m.IDENTITY_NAME] = PROTOCOL_VERSION, drive.name_code
    for axis in range(2):
        mail[m.IDENTITY_HAS_BRAKE_OUTER + axis] = drive.joints[axis].has_brake


@compiled
def report_identity_unit(mail: np.ndarray, drive: Drive) -> None:
    """Put the serial number and the units of torque into the mail."""
    mail[m.IDENTITY_UNIT] = 1
    mail[m.IDENTITY_UNIT_SERIAL_NUMBER] = drive.serial_number
    for axis in range(2):
        mail[m.IDENTITY_UNIT_TORQUE_EXPONENT_OUTER + axis] = drive.joints[axis].exponent
