"""Where each number of an axis' control law lives: parameters in `C`, state in `H`, both as offsets within an axis'
block.
"""

from __future__ import annotations

from enum import IntEnum


class Mode(IntEnum):
    """What an axis is asked to follow."""

    OFF = 0
    TORQUE = 1
    RATE = 2
    POSITION = 3
    INERTIAL_RATE = 4
    #: a direction in space, held by both axes together through their position loops
    POINTING = 5


class AntiWindup(IntEnum):
    """What keeps an integrator from growing while its output is limited."""

    NONE = 0
    CLAMPING = 1
    BACK_CALCULATION = 2


# --- C: parameters of one axis ----------------------------------------------------------------------------------------
#: position loop: encoder error (rad) to joint rate reference (rad/s)
POSITION_KP, POSITION_KI, POSITION_ANTI_WINDUP, POSITION_TRACKING, RATE_REFERENCE_LIMIT = range(5)
#: rate loop: gyro error (rad/s) to controller units; torque = scale times units
RATE_KP, RATE_KI, RATE_ANTI_WINDUP, RATE_TRACKING, TORQUE_SCALE, TORQUE_LIMIT = range(5, 11)
#: prefilter of the position reference: y += (1 - decay) (gain u - y); corner = den[1] / den[0], 1/s; 0 means none
PREFILTER_GAIN, PREFILTER_DECAY, PREFILTER_CORNER = range(11, 14)
#: share of the reference's slope that is fed forward to the rate loop, and whether the base rate is added to a joint
#: rate reference
RATE_FEEDFORWARD, BASE_RATE_SHARE = 14, 15
#: compensation, zero means none: Coulomb (N m), viscous (N m s/rad), width of the smoothed sign (rad/s), mass moment of
#: the body (kg m)
COULOMB, VISCOUS, SIGN_WIDTH, MOMENT_X, MOMENT_Y, MOMENT_Z = range(16, 22)
#: the prefilter's output moves no faster than these (rad/s, rad/s^2); zero means no limit
PREFILTER_RATE, PREFILTER_ACCELERATION = 22, 23
#: what the model gives (`model_control`): whether the reference is shaped without delay, friction fed forward, and an
#: observer closes the loops; inertia about the axis (kg m^2); ticks from a torque to its effect
SHAPED, FRICTION_FORWARD, OBSERVED, INERTIA, DELAY_TICKS = range(24, 29)
#: friction of the model: Ts, Tc (N m), vs (rad/s), sigma0 (N m/rad), sigma1, sigma2 (N m s/rad), delta
FRICTION = 29
FRICTION_TS, FRICTION_TC, FRICTION_VS, FRICTION_SIGMA0, FRICTION_SIGMA1, FRICTION_SIGMA2, FRICTION_DELTA = range(29, 36)
#: the gyro's lag over a tick, second order: a11, a12, a21, a22, b1, b2; all zero for an ideal one
GYRO_LAG = 36
#: what an innovation of encoder (rad) and gyro (rad/s) corrects: two numbers for each state of the observer
OBSERVER_GAIN = 42
OBSERVER_STATES = 6
#: gains of the loops while the observer closes them: joint rate over position error (1/s), units over rate error
OBSERVER_POSITION_KP = OBSERVER_GAIN + 2 * OBSERVER_STATES
OBSERVER_RATE_KP = OBSERVER_POSITION_KP + 1
#: whether the model is watched: share of a tick in its window (zero: not watched), step of its fading in a tick, least
#: mean square of what is fed forward that is judged (N m)^2, and of the feedback's changes: share of a tick in their
#: window, largest mean square (N m)^2
WATCH_SHARE, FADE_STEP, LEAST_TOLD, SHAKING_SHARE, MOST_SHAKING = range(OBSERVER_RATE_KP + 1, OBSERVER_RATE_KP + 6)
#: torque over position by the model: whether it is fed forward, how many cogging ripples, each amplitude (N m), ripples
#: a turn, phase (rad); the cable's stiffness (N m/rad) and where it does not pull (rad); torque that the drive gives at
#: zero command (N m)
NAMED_FORWARD, RIPPLE_COUNT = OBSERVER_RATE_KP + 6, OBSERVER_RATE_KP + 7
RIPPLES, MOST_RIPPLES, RIPPLE_SIZE = RIPPLE_COUNT + 1, 4, 3
CABLE_STIFFNESS, CABLE_REST, DRIVE_OFFSET = range(RIPPLES + MOST_RIPPLES * RIPPLE_SIZE, RIPPLES + 15)
#: friction over temperature: rows of a table (zero: none), fall of viscosity per kelvin from 20 degC on, then the rows,
#: each a temperature (degC) and the numbers as from FRICTION on
FRICTION_ROWS, VISCOSITY_FALL = RIPPLES + 15, RIPPLES + 16
FRICTION_TABLE, MOST_FRICTION_ROWS, FRICTION_ROW_SIZE = RIPPLES + 17, 8, 8
#: levels of friction taken from the residual: share of a tick in their window (zero: off), least and largest level
ADAPT_SHARE, LEAST_LEVEL, LARGEST_LEVEL = range(FRICTION_TABLE + 64, FRICTION_TABLE + 67)
#: table over position and direction: whether it is used; what of a residual a pass over a bin takes in (zero: frozen),
#: largest entry (N m), joint rates between which it learns (rad/s); then the entries it begins with (N m), of the
#: positive direction, then of the negative one
LEARNS, LEARN_SHARE, LARGEST_LEARNED, SLOWEST_LEARNED, FASTEST_LEARNED = range(FRICTION_TABLE + 67, FRICTION_TABLE + 72)
GIVEN_TABLE = FRICTION_TABLE + 72
#: bins of a turn
LEARNED_BINS = 720
CONTROL_PARAMETERS = GIVEN_TABLE + 2 * LEARNED_BINS

# --- H: state of one axis ---------------------------------------------------------------------------------------------
#: integrators of the two loops (rad/s; controller units), prefilter output (rad), torque of the last tick (N m)
POSITION_INTEGRAL, RATE_INTEGRAL, FILTERED, TORQUE = range(4)
#: what the loops followed at the last tick, for limits and the record: loop reference and its error
LOOP_REFERENCE, LOOP_ERROR = 4, 5
#: slope of the prefilter's output, rad/s
FILTERED_RATE = 6
#: shaped reference: position (rad), rate, acceleration; what of the asked one is still to come (rad), how fast that
#: changes (rad/s); the asked reference and its slope one tick before
SHAPED_POSITION, SHAPED_RATE, SHAPED_ACCELERATION, TO_COME, TO_COME_RATE, ASKED, ASKED_SLOPE = range(7, 14)
#: deflection of the bristles of the friction that is fed forward (rad)
BRISTLE = 14
#: observer: joint position (rad), joint rate, disturbance as an acceleration (rad/s^2), what the gyro reads beyond
#: joint and base rate (rad/s), the gyro's lag (its output, and the slope of that)
ESTIMATE = 15
EST_POSITION, EST_RATE, EST_DISTURBANCE, EST_OFFSET, EST_GYRO, EST_GYRO_SLOPE = range(15, 21)
#: torque that does not accelerate the joint: weight, friction, coupling (N m); inertia that the rest moves (kg m^2)
DRAG, MOVED_INERTIA = 21, 22
#: accelerations that past torques were to bring (rad/s^2), the newest first
PENDING = 23
MOST_DELAY_TICKS = 8
#: watch over the model: what it would feed forward, all of it (N m); means over the window of that times the torque
#: sent, of its square, and how full the window is; whether it is stale, how far it is faded out (0 to 1)
FORWARD = PENDING + MOST_DELAY_TICKS + 1
EXPLAINED, TOLD, SEEN, STALE, DISTRUST = range(FORWARD + 1, FORWARD + 6)
#: feedback part of the last torque (N m), mean square of its changes, whether the observer has been left
LAST_FEEDBACK, SHAKING, UNOBSERVED = range(FORWARD + 6, FORWARD + 9)
#: rate (rad/s) that the reference will ask for at the next tick if it goes on as it does, the torque (N m) that it asks
#: for now beyond that, and the mean square of this torque
FORESEEN, JUMP, JUMPING = range(FORWARD + 9, FORWARD + 12)
#: friction fed forward without its levels: sliding part (zero while bristles bend), viscous part (N m); what the
#: levels are beyond one
SLIDING_PART, VISCOUS_PART, SLIDING_LEVEL, VISCOUS_LEVEL = range(FORWARD + 12, FORWARD + 16)
#: regression of what friction lacks: means over the window, rows of an upper triangle each with its right side; and
#: room to solve it
REGRESSORS = 5
LEVEL_SUMS = FORWARD + 16
LEVEL_WORK = LEVEL_SUMS + REGRESSORS * (REGRESSORS + 3) // 2
#: viscous and sliding level beyond one as estimated; as they were at the last reversal; squares of how far reversals
#: shifted them; reversals so far, and which way the joint slid last
LEVEL_ESTIMATE = LEVEL_WORK + REGRESSORS * (REGRESSORS + 1)
LEVEL_BEFORE, LEVEL_SHIFTS, LEVEL_REVERSALS, LEVEL_SIDE = (LEVEL_ESTIMATE + k for k in (2, 4, 6, 7))
#: the levels as they were last told
TOLD_SLIDING, TOLD_VISCOUS = LEVEL_ESTIMATE + 8, LEVEL_ESTIMATE + 9
#: acceleration of the tick before (rad/s^2), its change (rad/s^3), and the mean product of the viscous part and of how
#: fast the torque that accelerates changes (N^2 m^2/s)
LAST_ACCELERATION, JERK, LATE_SUM = (LEVEL_ESTIMATE + k for k in (10, 11, 12))
#: what of the table over position and direction was learned (N m), laid out as GIVEN_TABLE
LEARNED_TABLE = LEVEL_ESTIMATE + 13
CONTROL_STATES = LEARNED_TABLE + 2 * LEARNED_BINS
