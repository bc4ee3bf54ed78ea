"""Where each number of the host lives: state `H` and configuration `C` (float64), state `G` (int64), `plan`
(float64).
"""

from __future__ import annotations

from gimbal_hil.loop.control import CONTROL_PARAMETERS, CONTROL_STATES

OUTER, INNER, AXES = 0, 1, 2
#: window of the runaway guard, in which the configured disturbance adds up
MOMENTUM_WINDOW_S = 0.03
#: of the configured deceleration, below which torque is too little to brake with at all
LEAST_BRAKING_SHARE = 0.05

# --- C: configuration
#: times in ticks are whole numbers
STEP_S, CONNECT_TICKS, LOST_TICKS, SYNCHRONISE_TICKS, RESET_PULSE_TICKS, STOP_TICKS, REST_TICKS, CONTROL_TICKS = range(
    8
)
(
    DEADMAN_WINDOW,
    DEADMAN_REACTION,
    AUTOMATIC_RECONNECT,
    BASE_LOST_TICKS,
    SET_POINT_LAG_TICKS,
    DEBOUNCE_TICKS,
    FOLLOWING_TICKS,
) = range(8, 15)
#: share of a new sample in the filter that compares gyro and encoder
PLAUSIBILITY_SHARE = 15
#: the antenna that may be connected: code of its name, serial number; negative for any
PINNED_NAME, PINNED_SERIAL = 16, 17
#: gyro against encoder over a window: share of the past kept, share of the path that they may differ by; motion against
#: torque: likewise
DRIFT_KEPT, DRIFT_SHARE, MOMENTUM_KEPT, MODEL_SHARE = range(18, 22)
#: time that a torque may act late (s); whether the weight of the bodies is expected
LATE_S, EXPECTS_WEIGHT = 22, 23
#: whether base motion is extrapolated from when it was true, and whether torques are computed from the model's bodies
EXTRAPOLATES_BASE, FEEDS_BODIES = 24, 25
#: the model's bodies: parameters of the plant up to the outer tensor, at their own offsets, then `body_numbers`
MODEL_TENSOR, MODEL_BODY = 26, 36
#: a direction in space: error (rad) beyond which it is muted and below which no longer; ticks without a sample after
#: which it is muted, ticks without attitude that the gyros hold it
MUTE_BEYOND, MUTE_BELOW, MUTE_TICKS, COAST_TICKS = 48, 49, 50, 51
#: what holds an axis that a plan does not name: UnnamedAxis
UNNAMED_AXIS = 52
#: two numbers of one sensor over a long window: share of the past kept, 0 for none, and how long it is (s)
LONG_KEPT, LONG_WINDOW_S = 53, 54
#: one block per axis: the control law's parameters, then the supervisor's limits
AXIS_C = 55
(
    POSITION_LOW,  # soft limits of the joint (rad), -inf and inf without
    POSITION_HIGH,
    WRAP_LOW,  # how far the cable may be wound (rad)
    WRAP_HIGH,
    TRAVEL_MARGIN,  # beyond a soft limit by this much (rad) is a fault
    MAX_RATE,  # joint rate (rad/s)
    MAX_FOLLOWING_POSITION,  # following error of the position loop (rad)
    MAX_FOLLOWING_RATE,  # following error of the rate loop (rad/s)
    MAX_DISAGREEMENT,  # gyro against encoder (rad/s)
    BRAKING_RAD_S2,  # deceleration that a stop asks for; braking distance counts on no more, see `limits.braking`
    REST_RATE,  # below this joint rate (rad/s) an axis is at rest
    MAX_TEMPERATURE,  # winding (degC)
    MAX_DRIFT,  # gyro against encoder over the window (rad)
    STUCK_TICKS,  # samples in a row after which a gyro that has noise is stuck, 0 for a gyro that may repeat itself
    EXPECTED_INERTIA,  # of the axis (kg m2), 0 for no guard on motion against torque
    DISTURBANCE,  # impulse within that guard's window which is neither the torque's nor the weight's (N m s)
    EXPECTED_MOMENT,  # mass times centre of gravity of the axis' body, in its axes: x, y, z (kg m)
) = range(CONTROL_PARAMETERS, CONTROL_PARAMETERS + 17)
AXIS_C_SIZE = CONTROL_PARAMETERS + 19
C_SIZE = AXIS_C + AXES * AXIS_C_SIZE

# --- H: state
#: base as last heard: roll, pitch, yaw (rad), p, q, r (rad/s), acceleration of the pivot without gravity (m/s^2), in
#: base axes
BASE_ANGLES, BASE_RATES, BASE_ACCELERATION = 0, 3, 6
#: what pulls at a body on this base: gravity less the pivot's acceleration (m/s^2), in base axes
BASE_GRAVITY = 9
#: base as it is now: rates (rad/s), angular acceleration (rad/s^2), gravity less the pivot's acceleration (m/s^2)
BASE_NOW, BASE_TURNING, BASE_FELT = 12, 15, 18
#: time since the attitude was true, and how old what the navigation tells is when it is sent (s)
ATTITUDE_AGE_S, NAVIGATION_AGE_S = 21, 22
#: attitude that is carried on while none is heard: 1 while so, roll, pitch, yaw (rad), p, q, r (rad/s), where the
#: joints stood (rad)
CARRIED, CARRIED_ANGLES, CARRIED_RATES, CARRIED_JOINTS = 24, 25, 28, 31
#: a direction in space: joints that look there (rad, rad/s), angle between it and where the antenna looks (rad)
TOWARDS, TOWARDS_RATES, POINTING_ERROR = 33, 35, 37
#: which way round the azimuth passes the zenith (-1, 1), 0 away from it
KEYHOLE_SIDE = 38
#: angular acceleration of the base half-way between the last two rates, NaN where they lie too far apart, and at the
#: last one (rad/s^2), and how it changes (rad/s^3)
BASE_HALFWAY, BASE_TURNED, BASE_JERK = 40, 43, 46
#: one block per axis: the control law's state, then what was measured and asked
AXIS_H = 49
(
    MEASURED_POSITION,  # encoder (rad)
    MEASURED_RATE,  # gyro (rad/s)
    BASE_RATE,  # inertial rate of the axis with its joint at rest (rad/s)
    FEEDFORWARD,  # compensation torque (N m)
    REFERENCE,  # of the segment, in the mode's unit, and its slope
    SLOPE,
    START_VALUE,  # what a reference with origin START counts from, and where a move starts
    MOTOR_TORQUE,  # measured by the drive (N m)
    MOTOR_TEMPERATURE,  # degC
    LAST_POSITION,  # encoder one sample before (rad)
    ENCODER_RATE,  # low-passed derivative of the encoder, and low-passed joint rate from the gyro (rad/s)
    GYRO_RATE,
    TORQUE_STEP,  # what a raw torque of 1 is on this antenna (N m), and the largest raw torque within the axis' limit
    MOST_TORQUE,
    DRIFT,  # see `plausibility`
    PATH,
    MOMENTUM,
    EFFORT,
    IMPULSE,
    QUIET_MOMENTUM,
    PEAK_TORQUE,
    LATE_IMPULSE,
    LAST_RATE,
    LAST_JOINT_RATE,
    LAST_RATE_CHANGE,  # of the gyro from sample to sample (rad/s), NaN where two did not follow each other
    GYRO_STEP,  # smallest change of the gyro that was seen (rad/s), 0 before there was one
    CURVE,  # slope of SLOPE (rad/s^2), NaN where nobody knows it
    TEMPERATURE_HEARD,  # 1 once the drive told the motor's temperature
    PULL,  # of the body's expected weight about the axis, either way (N m)
    SEEN_MOMENTUM,  # see `plausibility`
    LONG_DRIFT,
    LONG_PATH,
) = range(CONTROL_STATES, CONTROL_STATES + 32)
AXIS_H_SIZE = CONTROL_STATES + 32
#: what each axis said in its last samples, one number of position and rate
SAID, SAID_SIZE = AXIS_H + AXES * AXIS_H_SIZE, 300
H_SIZE = SAID + AXES * SAID_SIZE

# --- G: state
#: HostState, why it stops or is in FAULT, ticks in it, requests of the operator since the last tick (bits), number of
#: this tick
STATE, CAUSE, STATE_AGE, REQUESTS, LAST_TICK = range(5)
#: feedback: ticks since a full set, LinkStatus, ticks in a row with one; base: ticks since heard
FEEDBACK_AGE, LINK_STATUS, FRESH_IN_A_ROW, BASE_AGE = range(6, 10)
#: drive: as last reported
DRIVE_STATE, DRIVE_FAULT, LAST_SEQUENCE, DEADMAN_MARGIN, DRIVE_LIMITS = range(10, 15)
#: what is sent: sequence of the last set-point, drive_control as last sent (packed), ticks since, permission to reset
#: any drive fault, whether the drive is allowed back from a travel limit
SENT_SEQUENCE, SENT_CONTROL, CONTROL_AGE, MAY_RESET, CLEAR_TRAVEL = range(15, 20)
#: plan: how many segments, the one in force, its id, the tick at which it began, whether it runs (2: the next one is
#: due)
PLAN_LENGTH, SEGMENT, SEGMENT_LABEL, SEGMENT_START, SEGMENT_RUNS = range(20, 25)
#: ticks in a row: at rest while stopping, set-points not heard by the drive, each of the two end conditions
REST_COUNT, LAG_COUNT, END_TICKS, EVENT_COUNT = 25, 26, 27, 29
#: periods that the antenna was behind the host in its last sample
BEHIND = 28
#: id of the segment that this tick belongs to, -1 for none; whole ticks that were skipped just before it
TICK_SEGMENT, SKIPPED = 30, 31
#: who answers: bits of what was heard (IDENTITY_HEARD), protocol version, code of its name, serial number; why it may
#: not be connected
IDENTITY, PEER_PROTOCOL, PEER_NAME, PEER_SERIAL, REFUSAL = range(32, 37)
#: the device's tick as last heard, feedback sets in a row in which it stood still; how the drive is asked to stop
#: (StopReaction); the device's tick of the last full set
DEVICE_TICK, STATUS_SAME, STOP_KIND, SAMPLE_TICK = range(37, 41)
#: PointingState, 1 while muted, ticks since the attitude was heard, ticks since the pointing error was known
POINTING_STATE, MUTED, ATTITUDE_TICKS, ERROR_TICKS = range(41, 45)
#: periods of the antenna between the last two full sets, beyond the ticks of the host and what it was behind
EXTRA_PERIODS = 45
#: one block per axis: mode in force, ticks in a row that a check failed
AXIS_G = 46
MODE, OVERSPEED_COUNT, FOLLOWING_COUNT, DISAGREE_COUNT = range(4)
HAS_BRAKE, BRAKE_STATE = range(4, 6)
#: samples in a row in which gyro and encoder did not change; samples at rest without torque, and in how many of them
#: the gyro's noise was seen; which soft limit the axis is beyond (-1, 0, 1)
GYRO_SAME, ENCODER_SAME, GYRO_QUIET_TICKS, GYRO_QUIET_CHANGES, OUTSIDE = range(6, 11)
#: samples in a row that told nothing new under a torque that must move the axis; 1 once a position was heard, 2 since
#: one came that the axis cannot have gone to
STILL_COUNT, PLACE = 11, 12
#: 1 while the axis is off and its brake is to be closed beside one under torque
BRAKED = 13
#: samples that were kept since a silence; 1 while they repeat themselves
SAID_COUNT, REPEATS = 14, 15
AXIS_G_SIZE = 16
#: ring of events: tick, code, three numbers
EVENTS = AXIS_G + AXES * AXIS_G_SIZE
EVENT_SIZE = 5
EVENT_CAPACITY = 128
G_SIZE = EVENTS + EVENT_CAPACITY * EVENT_SIZE

#: IDENTITY once both frames were heard since the link was last lost
IDENTITY_HEARD = 3
#: bits of REQUESTS
REQUEST_START, REQUEST_STOP, REQUEST_RESET, REQUEST_QUICK_STOP, REQUEST_DISTRUST = 1, 2, 4, 8, 16

# --- plan: segments in a row, then the rows of tables
#: id (label), duration (ticks, 0 without end), ticks between recorded rows (0: as the recording says), then what to do
#: after the last one
SEGMENT_ID, DURATION_TICKS, RECORD_EVERY, AFTERWARDS = range(4)
#: two end conditions: EndKind, axis, threshold, ticks in a row that it must hold
END_CONDITIONS = 2
END = 4
END_SIZE = 4
END_KIND, END_AXIS, END_THRESHOLD, END_HOLD_TICKS = range(4)
#: one block per axis: mode, shape, origin, the shape's parameters, guards
AXIS_SEGMENT = END + END_CONDITIONS * END_SIZE
SEGMENT_MODE, SHAPE, ORIGIN = range(3)
SHAPE_PARAMETERS = 3
MAX_SHAPE_PARAMETERS = 6
GUARD_LOW, GUARD_HIGH, GUARD_RATE, GUARD_TORQUE = range(
    SHAPE_PARAMETERS + MAX_SHAPE_PARAMETERS, SHAPE_PARAMETERS + MAX_SHAPE_PARAMETERS + 4
)
AXIS_SEGMENT_SIZE = SHAPE_PARAMETERS + MAX_SHAPE_PARAMETERS + 4
SEGMENT_SIZE = AXIS_SEGMENT + AXES * AXIS_SEGMENT_SIZE
#: AFTERWARDS: hold the last reference (rates and torques become zero), or stop and switch torque off
HOLD_ON, SWITCH_OFF = 0, 1


def axis_c(axis: int) -> int:
    """Offset in C of an axis' block."""
    return AXIS_C + axis * AXIS_C_SIZE


def axis_h(axis: int) -> int:
    """Offset in H of an axis' block."""
    return AXIS_H + axis * AXIS_H_SIZE


def axis_g(axis: int) -> int:
    """Offset in G of an axis' block."""
    return AXIS_G + axis * AXIS_G_SIZE
