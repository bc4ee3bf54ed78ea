"""States, requests, causes and flags that fields of the wire carry."""

from __future__ import annotations

from enum import Enum, IntEnum, IntFlag


class DriveState(IntEnum):
    """States of the drive after CiA 402 (IEC 61800-7-201)."""

    NOT_READY = 0
    SWITCH_ON_DISABLED = 1
    READY_TO_SWITCH_ON = 2
    SWITCHED_ON = 3
    OPERATION_ENABLED = 4
    QUICK_STOP_ACTIVE = 5
    FAULT_REACTION_ACTIVE = 6
    FAULT = 7

    @property
    def gives_torque(self) -> bool:
        """Whether the drive may apply torque: commanded, or by itself to brake and hold."""
        return self in (DriveState.OPERATION_ENABLED, DriveState.QUICK_STOP_ACTIVE, DriveState.FAULT_REACTION_ACTIVE)


class DriveRequest(IntEnum):
    """Commands of the CiA 402 state machine; faults are reset by an edge of `fault_reset`."""

    NONE = 0
    SHUTDOWN = 1
    SWITCH_ON = 2
    ENABLE_OPERATION = 3
    DISABLE_OPERATION = 4
    DISABLE_VOLTAGE = 5
    QUICK_STOP = 6


class FaultCode(IntEnum):
    """Why the drive is in fault, or why its state changed."""

    NONE = 0
    DEADMAN = 1
    TRAVEL_LIMIT = 2
    OVERSPEED = 3
    OVERTEMPERATURE = 4
    UNDERVOLTAGE = 5
    COMMUNICATION = 6
    ENCODER = 7
    GYRO = 8
    INTERNAL = 9
    #: gyro and encoder do not tell of one motion
    SENSORS_DISAGREE = 10
    #: a sensor repeats itself where its noise should be
    SENSOR_STUCK = 11
    #: the axis does not move as its torque says
    RUNAWAY = 12
    #: the holding brake slips
    HOLDING_BRAKE = 13


class StopReaction(IntEnum):
    """How the drive stops: no torque; shorted winding; ramp to rest and hold, by encoder alone; torque against the
    rate, by gyro alone.
    """

    COAST = 0
    BRAKE = 1
    DECELERATE_AND_HOLD = 2
    GYRO_STOP = 3


class BrakeCommand(IntEnum):
    """What the host asks of an axis' holding brake; AUTOMATIC engages it whenever no axis is under torque."""

    AUTOMATIC = 0
    ENGAGE = 1
    RELEASE = 2


class BrakeState(IntEnum):
    """Where an axis' holding brake stands."""

    ABSENT = 0
    RELEASED = 1
    ENGAGED = 2


class LimitFlags(IntFlag):
    """Limits that act at this tick."""

    OUTER_TORQUE = 1
    INNER_TORQUE = 2
    OUTER_TRAVEL_LOW = 4
    OUTER_TRAVEL_HIGH = 8
    INNER_TRAVEL_LOW = 16
    INNER_TRAVEL_HIGH = 32
    OUTER_RATE = 64
    INNER_RATE = 128


#: the enumerations that appear in fields, in the order of the emitted files
ENUMERATIONS: tuple[type[Enum], ...] = (
    DriveState,
    DriveRequest,
    FaultCode,
    StopReaction,
    BrakeCommand,
    BrakeState,
    LimitFlags,
)
