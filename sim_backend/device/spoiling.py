"""Faults that the virtual antenna can be given: sensors that lie and motors that are wired wrong, each from a tick on.

A real antenna has them by itself; here they are switched on by `Device.spoil`, so that guards can be tried. They act
where the firmware reads its sensors and drives its motor: firmware and host see the same lie.
"""

from __future__ import annotations

from enum import IntEnum

from firmware_protocol.compiling import compiled
from sim_backend.device.records import SCALE_BITS, Drive, Fault, Joint


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
#: what of an axis can be spoilt
PARTS = ("encoder", "gyro", "motor")


def spoil(drive: Drive, axis: int, part: str, kind: Spoilt, amount: int = 0) -> None:
    """Give an axis a fault of its `encoder`, `gyro` or `motor` from the next tick on; NOTHING mends it."""
    fault: Fault = getattr(drive.joints[axis], f"{part}_spoilt")
    fault.kind, fault.amount, fault.since, fault.kept = int(kind), amount, 0, 0


@compiled
def spoilt_reading(fault: Fault, raw: int, about_zero: bool, highest: int) -> int:
    """What a faulty sensor reads in place of `raw`; a reversed one turns about zero, or about where it was."""
    kind, amount = fault.kind, fault.amount
    if kind == _NOTHING:
        return raw
    if fault.since == 0:
        fault.kept = raw
    fault.since += 1
    if kind == _FROZEN:
        return int(fault.kept)
    if kind == _REVERSED:
        return -raw if about_zero else int(2 * fault.kept - raw)
    if kind == _DRIFTING:
        return raw + int(amount * fault.since >> SCALE_BITS)
    if kind == _NOISY:
        # a number that looks random and is the same every time
        mixed = (fault.since * 2654435761) & 0xFFFFFFFF
        return raw + int((mixed * (2 * amount + 1) >> 32) - amount)
    return raw + amount if kind == _OFF else highest


@compiled
def spoilt_torque(joint: Joint, raw: int, powered: bool) -> int:
    """What a faulty motor makes of the torque that the firmware asks of it; `powered` while the firmware has its power
    stage on.
    """
    fault = joint.motor_spoilt
    kind = fault.kind
    if kind == _NOTHING:
        return raw
    if fault.since == 0:
        fault.kept, fault.since = raw, 1
    if kind == _FROZEN:
        return int(fault.kept)
    if kind == _REVERSED:
        return -raw
    if kind == _DEAD:
        return 0
    # a current sensor that is off, which counts while there is current; a stage that keeps its torque keeps it for good
    return raw + int(fault.amount) if powered else raw
