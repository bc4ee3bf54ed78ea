"""Who the antenna says it is."""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from firmware_protocol.schema import PROTOCOL_VERSION
from sim_backend.device.layout import AXIS_J, AXIS_J_SIZE, EXPONENT, HAS_BRAKE, NAME_CODE, SERIAL_NUMBER

_INNER = AXIS_J + AXIS_J_SIZE


@compiled
def report_identity(mail: np.ndarray, J: np.ndarray) -> None:
    """Put the protocol's version, the name's code and the brakes into the mail."""
    mail[m.IDENTITY] = 1
    mail[m.IDENTITY_PROTOCOL_VERSION], mail[m.IDENTITY_NAME] = PROTOCOL_VERSION, J[NAME_CODE]
    mail[m.IDENTITY_HAS_BRAKE_OUTER], mail[m.IDENTITY_HAS_BRAKE_INNER] = J[AXIS_J + HAS_BRAKE], J[_INNER + HAS_BRAKE]


@compiled
def report_identity_unit(mail: np.ndarray, J: np.ndarray) -> None:
    """Put the serial number and the units of torque into the mail."""
    mail[m.IDENTITY_UNIT] = 1
    mail[m.IDENTITY_UNIT_SERIAL_NUMBER] = J[SERIAL_NUMBER]
    mail[m.IDENTITY_UNIT_TORQUE_EXPONENT_OUTER], mail[m.IDENTITY_UNIT_TORQUE_EXPONENT_INNER] = (
        J[AXIS_J + EXPONENT],
        J[_INNER + EXPONENT],
    )
