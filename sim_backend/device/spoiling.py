"""Faults that the virtual antenna can be given: sensors that lie and motors that are wired wrong, each from a tick on.

A real antenna has them by itself; here they are switched on by `Device.spoil`, so that guards can be tried. They act
where the firmware reads its sensors and drives its motor: firmware and host see the same lie.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.device.layout import (
    AXIS_J,
    AXIS_J_SIZE,
    ENCODER_SPOILT,
    GYRO_SPOILT,
    MOTOR_SPOILT,
    SCALE_BITS,
    SPOILT_SIZE,
)


class Spoilt(IntEnum):
    """What is wrong with a sensor or a motor; the amount counts in the wire's raw units."""

    NOTHING = 0
    #: a sensor repeats its last value; a motor keeps its last torque
    FROZEN = 1
    #: a sensor counts the other way from now on; a motor turns the other way
    REVERSED = 2
    #: the value walks away by the amount in every tick, 1 / 2^16 of a raw unit; a motor adds the amount while its power
    #: stage is on
    DRIFTING = 3
    #: the value is off by the amount, a motor's torque while its power stage is on
    OFF = 4
    #: a sensor answers the end of its range; a motor gives nothing
    DEAD = 5
    #: the value jumps by up to the amount either way in every tick
    NOISY = 6


_NOTHING, _FROZEN, _REVERSED, _DRIFTING = (
    int(Spoilt.NOTHING),
    int(Spoilt.FROZEN),
    int(Spoilt.REVERSED),
    int(Spoilt.DRIFTING),
)
_OFF, _DEAD, _NOISY = int(Spoilt.OFF), int(Spoilt.DEAD), int(Spoilt.NOISY)
_KIND, _AMOUNT, _SINCE, _KEPT = range(SPOILT_SIZE)
#: places of a sensor's or motor's fault in the axis' block
PARTS = {"encoder": ENCODER_SPOILT, "gyro": GYRO_SPOILT, "motor": MOTOR_SPOILT}


def spoil(J: np.ndarray, axis: int, part: str, kind: Spoilt, amount: int = 0) -> None:
    """Give an axis a fault of its `encoder`, `gyro` or `motor` from the next tick on; NOTHING mends it."""
    slot = AXIS_J + axis * AXIS_J_SIZE + PARTS[part]
    J[slot : slot + SPOILT_SIZE] = (int(kind), amount, 0, 0)


@compiled
def spoilt_reading(J: np.ndarray, slot: int, raw: int, about_zero: bool, highest: int) -> int:
    """What a faulty sensor reads in place of `raw`; a reversed one turns about zero, or about where it was."""
    kind, amount = J[slot + _KIND], J[slot + _AMOUNT]
    if kind == _NOTHING:
        return raw
    if J[slot + _SINCE] == 0:
        J[slot + _KEPT] = raw
    J[slot + _SINCE] += 1
    if kind == _FROZEN:
        return int(J[slot + _KEPT])
    if kind == _REVERSED:
        return -raw if about_zero else int(2 * J[slot + _KEPT] - raw)
    if kind == _DRIFTING:
        return raw + int(amount * J[slot + _SINCE] >> SCALE_BITS)
    if kind == _NOISY:
        # a number that looks random and is the same every time
        mixed = (J[slot + _SINCE] * 2654435761) & 0xFFFFFFFF
        return raw + int((mixed * (2 * amount + 1) >> 32) - amount)
    return raw + amount if kind == _OFF else highest


@compiled
def spoilt_torque(J: np.ndarray, j: int, raw: int, powered: bool) -> int:
    """What a faulty motor makes of the torque that the firmware asks of it; `powered` while the firmware has its power
    stage on.
    """
    slot = j + MOTOR_SPOILT
    kind = J[slot + _KIND]
    if kind == _NOTHING:
        return raw
    if J[slot + _SINCE] == 0:
        J[slot + _KEPT], J[slot + _SINCE] = raw, 1
    if kind == _FROZEN:
        return int(J[slot + _KEPT])
    if kind == _REVERSED:
        return -raw
    if kind == _DEAD:
        return 0
    # a current sensor that is off, which counts while there is current; a stage that keeps its torque keeps it for good
    return raw + int(J[slot + _AMOUNT]) if powered else raw
