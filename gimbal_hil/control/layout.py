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
CONTROL_PARAMETERS = 24

# --- H: state of one axis ---------------------------------------------------------------------------------------------
#: integrators of the two loops (rad/s; controller units), prefilter output (rad), torque of the last tick (N m)
POSITION_INTEGRAL, RATE_INTEGRAL, FILTERED, TORQUE = range(4)
#: what the loops followed at the last tick, for limits and the record: loop reference and its error
LOOP_REFERENCE, LOOP_ERROR = 4, 5
#: slope of the prefilter's output, rad/s
FILTERED_RATE = 6
CONTROL_STATES = 7
