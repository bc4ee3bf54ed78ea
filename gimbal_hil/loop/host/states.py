"""The host's states, causes and events: what the supervisor is in, why it changed, and what it reports."""

from __future__ import annotations

from enum import IntEnum
from typing import cast

import numpy as np


def number(value: int) -> int:
    """A constant for compiled code that is no Python literal: the compiler would make a copy of a function for each
    literal it is given.
    """
    return cast(int, np.int64(value))


#: for arguments that say nothing, or no and yes
NOTHING, YES = number(0), number(1)


class HostState(IntEnum):
    """Where the supervisor stands. Torque is sent in ACTIVE and STOPPING only."""

    #: no antenna answers
    WAITING = 0
    #: the drive is taken through its states to operation enabled
    SYNCHRONISING = 1
    #: ready, torque off
    IDLE = 2
    #: a segment is followed
    ACTIVE = 3
    #: rates are brought to zero, then IDLE
    STOPPING = 4
    #: torque off, drive stopped; left by a reset, or by the antenna's return when it had gone
    FAULT = 5


class LinkStatus(IntEnum):
    """How far feedback can be relied on: OK fresh at this tick, DEGRADED older (torque is held), LOST too old."""

    LOST = 0
    DEGRADED = 1
    OK = 2


class HostCause(IntEnum):
    """Why the host stopped or faulted, why a segment ended, or why a command was refused."""

    NONE = 0
    FEEDBACK_LOST = 1
    DRIVE_FAULT = 2
    DRIVE_LEFT_OPERATION = 3
    SYNCHRONISATION_TIMEOUT = 4
    STOP_TIMEOUT = 5
    SET_POINT_LOST = 6
    OVERSPEED = 7
    FOLLOWING_ERROR = 8
    GYRO_ENCODER_DISAGREE = 9
    TRAVEL = 10
    CABLE_WRAP = 11
    TEMPERATURE = 12
    NOT_A_NUMBER = 13
    #: a segment's own guard
    GUARD = 14
    OPERATOR = 15
    DURATION = 16
    END_CONDITION = 17
    REPLACED = 18
    #: a command came in a state that takes none
    NOT_READY = 19
    #: the antenna is not the one that may be connected
    WRONG_ANTENNA = 20
    #: gyro and encoder moved apart over seconds
    SENSOR_DRIFT = 21
    #: a gyro that had noise repeats itself
    GYRO_STUCK = 22
    #: feedback stands still behind live counters
    FEEDBACK_FROZEN = 23
    #: the axis does not move as its torque says
    RUNAWAY = 24
    #: the test before the first motion found it wired or configured wrong
    FIRST_TEST = 25
    #: a direction in space was held without attitude for as long as gyros may
    ATTITUDE_LOST = 26
    #: a position that the axis cannot have come to: a jump, a lost zero, a wrapped count
    POSITION_JUMP = 27


_NO_GUARDS = {
    HostCause.NONE,
    HostCause.OPERATOR,
    HostCause.DURATION,
    HostCause.END_CONDITION,
    HostCause.REPLACED,
    HostCause.NOT_READY,
}
#: causes that are a guard's
GUARD_CAUSES = tuple(cause for cause in HostCause if cause not in _NO_GUARDS)


class EventCode(IntEnum):
    """Kinds of entries in the event ring; each has up to three whole numbers."""

    #: from, to (HostState), cause
    STATE = 0
    #: place in the plan, id
    SEGMENT_STARTED = 1
    #: place in the plan, id, cause
    SEGMENT_ENDED = 2
    #: state of the host, cause
    COMMAND_REFUSED = 3
    #: from, to (LinkStatus) of the feedback
    LINK = 4
    #: from, to (DriveState), FaultCode
    DRIVE = 5
    #: cause, axis, of the check that tripped
    TRIPPED = 6
    #: 1 when base attitude and rate are heard, 0 when they are lost
    BASE = 7
    #: code of the antenna's name, serial number, Refusal
    IDENTITY = 8
    #: axis, 1 for the upper and 0 for the lower soft limit, of an axis that went past it without torque
    BEYOND_LIMIT = 9
    #: axis, ModelNews: what became of the trust in the model
    MODEL = 10
    #: PointingState, 1 while muted, pointing error in microradians
    POINTING = 11
    #: axis, levels of sliding and of viscous friction (thousandths of the model's)
    FRICTION_LEVELS = 12


class ModelNews(IntEnum):
    """What the watch over the model found."""

    NONE = 0
    #: the torque sent contradicts the feed-forward, which fades out
    STALE = 1
    #: it explains the torque again, and comes back
    RIGHT = 2
    #: the loops that the observer closes shake: the cascade closes them from now on
    SHAKES = 3


class PointingState(IntEnum):
    """How a direction in space is held."""

    #: none is asked for
    OFF = 0
    #: on the way there, muted
    ACQUIRING = 1
    #: held
    TRACKING = 2
    #: held by gyros and encoders, because no attitude is heard
    COASTING = 3


class Refusal(IntEnum):
    """Why an antenna may not be connected."""

    NONE = 0
    #: it speaks another version of the protocol
    PROTOCOL = 1
    #: its name or serial number is not the one that the configuration pins
    NAME = 2
    SERIAL_NUMBER = 3
    #: the configuration's torque limit is more than its frames can carry
    TORQUE_RANGE = 4
    #: it was another one a moment ago
    CHANGED = 5


class EndKind(IntEnum):
    """Conditions that end a segment before its duration is over; rate and torque count by size, position by value."""

    NONE = 0
    RATE_ABOVE = 1
    RATE_BELOW = 2
    POSITION_ABOVE = 3
    POSITION_BELOW = 4
    TORQUE_ABOVE = 5


class Shape(IntEnum):
    """Reference shapes; parameters are listed in `references`."""

    HOLD = 0
    RAMP = 1
    SINE = 2
    CHIRP = 3
    TRAPEZOID = 4
    SMOOTH = 5
    PULSES = 6
    TABLE = 7
    #: a table by the host's own ticks, so that it says when and not how long after
    TIMETABLE = 8


class UnnamedAxis(IntEnum):
    """What holds an axis that a plan does not name, beside one that it moves."""

    FREE = 0
    POSITION = 1
    BRAKE = 2


class AxisOff(IntEnum):
    """The one parameter of an axis in mode OFF: free because the plan says so, not named, held by its brake."""

    FREE = 0
    UNNAMED = 1
    BRAKED = 2


class ReferenceOrigin(IntEnum):
    """What a reference counts from: zero, or where the axis (or the reference before) is when the segment starts."""

    ABSOLUTE = 0
    START = 1
