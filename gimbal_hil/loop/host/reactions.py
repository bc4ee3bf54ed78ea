"""How the drive is asked to stop, by what went wrong: never with a sensor that is suspected."""

from __future__ import annotations

from firmware_protocol.compiling import compiled
from firmware_protocol.enumerations import StopReaction
from gimbal_hil.loop.host.states import HostCause, number

#: encoder and drive are trusted: a ramp to rest by the encoder, held there. Every other cause leaves a sensor, the
#: motor or the whole feedback in doubt: the winding is shorted, and an axis that its weight moves is held by its brake
BY_ENCODER = (
    HostCause.TRAVEL,
    HostCause.CABLE_WRAP,
    HostCause.OPERATOR,
    HostCause.ATTITUDE_LOST,
    HostCause.SET_POINT_LOST,
    HostCause.DRIVE_LEFT_OPERATION,
    HostCause.SYNCHRONISATION_TIMEOUT,
    # the gyro is the one in doubt
    HostCause.GYRO_STUCK,
)
_BY_ENCODER = tuple(number(cause) for cause in BY_ENCODER)
_RAMP, _SHORT = number(StopReaction.DECELERATE_AND_HOLD), number(StopReaction.BRAKE)


def stop_for(cause: HostCause) -> StopReaction:
    """How the drive is asked to stop for a cause."""
    return StopReaction.DECELERATE_AND_HOLD if cause in BY_ENCODER else StopReaction.BRAKE


@compiled
def stop_kind(cause: int) -> int:
    """`stop_for` in compiled code."""
    for trusted in _BY_ENCODER:
        if cause == trusted:
            return _RAMP
    return _SHORT
