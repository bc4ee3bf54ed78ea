"""Where each number of the antenna's firmware lives in `J` (int64): state and settings, all in the wire's raw integers.

The firmware computes in whole numbers only: what it compares with a limit is the very number that it reports, and a
copied `J` goes on bit for bit. Torque counts `TORQUE_STEP_NM` times two to the axis' exponent, position
`POSITION_STEP_RAD`, rate `RATE_STEP_RAD_S`, time ticks.
"""

from __future__ import annotations

# --- state
#: drive state, ticks in it; latched fault and what it is about; the tick of the last sample
STATE, STATE_AGE, FAULT, FAULT_DETAIL, TICK = range(5)
#: set-point: sequence of the last one taken (-1 before the first), ticks left before the deadman reacts, fresh ones
#: taken, repeats refused
LAST_SEQUENCE, MARGIN, TAKEN, REFUSED = range(5, 9)
#: deadman: window in ticks, reaction; what the drive does in this fault reaction
WINDOW, REACTION, ACTIVE_REACTION = range(9, 12)
#: drive_control: level of fault_reset when last heard, ticks since heard, whether torque that leads back from a travel
#: limit is allowed
RESET_LEVEL, CONTROL_AGE, TRAVEL_CLEARED = range(12, 15)
#: ticks in a row at rest while stopping; limits that act now; supply voltage as measured
REST_COUNT, LIMITS, SUPPLY = range(15, 18)
#: attitude as sampled with the last base_attitude, until base_heading has told the rest: raw yaw, tick
YAW, ATTITUDE_TICK = 18, 19

# --- settings of the whole drive
STARTUP_TICKS, CONTROL_SILENCE_TICKS, TRAVEL_REACTION, FAULT_REACTION, MIN_SUPPLY = range(20, 25)
REST_RATE, REST_TICKS, HOLD_TICKS, REACTION_TICKS = range(25, 29)
#: raw rate of one count a tick (fraction of SCALE), counts a tick of a raw rate of one (fraction of SCALE)
RATE_OF_COUNT, COUNT_OF_RATE = 29, 30
#: ticks that a holding brake takes to close; who the antenna is: code of its name, serial number
BRAKE_TICKS, NAME_CODE, SERIAL_NUMBER = range(31, 34)
#: raw rates by which encoder and gyro may differ: more is a fault; more than the second, and no stop relies on either
MAX_DISAGREEMENT, STOP_DISAGREEMENT = 34, 35
#: share of momentum that is remembered from tick to tick (fraction of SCALE)
MOMENTUM_KEPT = 36

# --- one block per axis
AXIS_J = 40
(
    SET_TORQUE,  # last set-point
    SET_ENABLE,
    APPLIED_TORQUE,  # what the drive asks of its current loop
    ENCODER,  # as sampled
    GYRO,
    JOINT_RATE,  # low-passed difference of the encoder
    WINDING,  # temperature
    SENSOR_FAULT,  # FaultCode of this axis' sensors, latched by nothing: as of the last sample
    # stopping reference: rate, position (fraction of SCALE), integral of the error (torque, fraction of SCALE)
    STOP_RATE,
    STOP_POSITION,
    STOP_INTEGRAL,
    BRAKE_COMMAND,  # BrakeCommand as last heard, BrakeState, ticks since it was to close
    BRAKE_STATE,
    BRAKE_AGE,
    SHORTED,  # whether the winding is shorted
    # see `runaway`: torque times ticks (fraction of SCALE), twice, then torque, then whether the axis ran away
    MOMENTUM,
    EFFORT,
    PEAK_TORQUE,
    RAN_AWAY,
    HAS_BRAKE,  # settings from here on
    EXPONENT,  # of two, by which a raw torque counts more than TORQUE_STEP_NM
    TORQUE_LIMIT,
    TRAVEL_LOW,
    TRAVEL_HIGH,
    RATE_LIMIT,
    OVERSPEED,
    MAX_WINDING,
    STOP_RATE_GAIN,  # torque per rate, per count, and per count and tick, fractions of SCALE
    STOP_POSITION_GAIN,
    STOP_INTEGRAL_GAIN,
    STOP_RATE_PER_TICK,  # deceleration
    # torque times ticks for a rate of one (fraction of SCALE), most impulse that is not the motor's, 0 for no guard
    IMPULSE_OF_RATE,
    STRANGE_IMPULSE,
    ENCODER_SPOILT,  # faults given on purpose, see `spoiling`: kind, amount, ticks since, value kept
) = range(34)
SPOILT_SIZE = 4
GYRO_SPOILT, MOTOR_SPOILT = ENCODER_SPOILT + SPOILT_SIZE, ENCODER_SPOILT + 2 * SPOILT_SIZE
AXIS_J_SIZE = ENCODER_SPOILT + 3 * SPOILT_SIZE
J_SIZE = AXIS_J + 2 * AXIS_J_SIZE

#: fixed point: a fraction is a whole number of 1 / 2^16
SCALE_BITS = 16
SCALE = 1 << SCALE_BITS
#: the joint rate takes over 1 / 2^2 of each new difference
JOINT_RATE_SHIFT = 2

#: `detail` of a drive_event whose cause is NONE: the request that was granted (DriveRequest), or one of these; of a
#: fault: the axis
DETAIL_BY_ITSELF, DETAIL_FAULT_RESET = 0, 7
#: the last sequence that a drive reports before its first set-point: the one before sequence 0
NO_SEQUENCE = -1


def axis_j(axis: int) -> int:
    """Offset in J of an axis' block."""
    return AXIS_J + axis * AXIS_J_SIZE
