"""Where each number of the plant lives in the arrays that compiled code works on.

`P` (float64) holds parameters, `K` (int64) structure, `X` (float64) state. Offsets are plain integers, because compiled
code takes module constants as literals. Units: SI; a linear axis reads m for rad, N for N m, kg for kg m^2.
"""

from __future__ import annotations

from enum import IntEnum

OUTER, INNER = 0, 1
MAX_AXES = 2


class PlantKind(IntEnum):
    """What the rigid body is."""

    GIMBAL = 0
    ROTARY = 1
    LINEAR = 2


class BaseKind(IntEnum):
    """How the base moves."""

    FIXED = 0
    CONSTANT_RATE = 1
    SINUSOID = 2
    RECORDED = 3


class HeldBy(IntEnum):
    """What acts on a joint without a torque from the current loop; they add."""

    NOTHING = 0
    SHORTED_WINDING = 1
    HOLDING_BRAKE = 2


class GravityReading(IntEnum):
    """Whose mass acts on the outer centre of gravity (docs/explanation/reading-the-thesis.md, eq. 2.52)."""

    SEPARATE_BODIES = 0
    TOTAL_MASS = 1


# --- K: structure
(
    KIND,
    AXES,
    GRAVITY_READING,
    SLIPS,
    BASE_KIND,
    STEPS_PER_TICK,
    SEED,
    TEMPERATURE_KNOTS,
    BASE_ROWS,
    BASE_TABLE,
    INSTANCES,
) = range(11)
#: for each hook: how many effect instances it has, and where in K their list begins
HOOK_COUNT = 16
HOOK_FIRST = 24
#: per instance: code of the effect, axis, offset of its parameters in P, offset of its states in X
INSTANCE = 32
INSTANCE_SIZE = 4
CODE, AXIS, PARAMETERS, STATES = range(INSTANCE_SIZE)
MAX_INSTANCES = 24
HOOK_LISTS = INSTANCE + INSTANCE_SIZE * MAX_INSTANCES
K_SIZE = HOOK_LISTS + 2 * MAX_INSTANCES

# --- P: parameters
STEP_S, GRAVITY_M_S2, INCLINE_SIN = 0, 1, 2
#: inertia tensors about the common pivot: xx, yy, zz, xy, xz, yz; a single axis keeps its inertia (mass) in the outer
#: zz
INERTIA_OUTER, INERTIA_INNER = 4, 10
XX, YY, ZZ, XY, XZ, YZ = range(6)
COG_OUTER, COG_INNER = 16, 19
MASS_OUTER, MASS_INNER = 22, 23
#: base motion: attitude at t = 0 (roll, pitch, yaw), rates (p, q, r), sinusoid amplitude, frequency, phase (roll,
#: pitch, yaw)
BASE_ATTITUDE, BASE_RATE, BASE_AMPLITUDE, BASE_FREQUENCY, BASE_PHASE, BASE_ROW_S = 24, 27, 30, 33, 36, 39
#: gravity in the axes of a base that does not move, or as it stands at t = 0
FIXED_GRAVITY = 40
#: how old what the inertial navigation tells is when it is sent
INS_AGE_S = 43
AXIS_BLOCK = 44
AXIS_SIZE = 48
#: within an axis block: friction
TS, TC, VS, SIGMA0, SIGMA1, SIGMA2, DELTA = range(7)
#: actuator: T = limit(lag((1 + gain error) u + offset)); limit 0 means none, lag decay exp(-h/tau) 0 means none,
#: LAG_MEAN is the mean of that decay over the step
GAIN_ERROR, OFFSET, LIMIT, LAG_DECAY, TORQUE_NOISE, LAG_MEAN = 8, 9, 10, 11, 12, 13
#: sensors; gyro filter is the exact discretisation of a second-order lag, GYRO_FILTER 0 means ideal
ENCODER_STEP, ENCODER_NOISE, GYRO_BIAS, GYRO_SCALE_ERROR, GYRO_NOISE, GYRO_STEP = 14, 15, 16, 17, 18, 19
GYRO_FILTER, GYRO_A11, GYRO_A12, GYRO_A21, GYRO_A22, GYRO_B1, GYRO_B2 = 20, 21, 22, 23, 24, 25, 26
#: travel: mechanical stops as a spring and damper beyond them; stiffness 0 means endless travel
STOP_LOW, STOP_HIGH, STOP_STIFFNESS, STOP_DAMPING = 28, 29, 30, 31
#: heat: T' = (ambient - T) / time constant + heating T_applied^2; time constant 0 means constant temperature
AMBIENT, THERMAL_TIME_S, HEATING = 32, 33, 34
#: start of the motion
START_POSITION, START_RATE = 36, 37
#: delta of the Stribeck curve that the axis' table is made for; 0 means none
BUMP_DELTA = 38
#: holding brake: largest torque, and the spring and damper by which it holds; damping of the shorted winding
BRAKE_TORQUE, BRAKE_STIFFNESS, BRAKE_DAMPING, SHORT_DAMPING = 39, 40, 41, 42
#: friction over temperature: knots of (temperature, Ts, Tc, vs, sigma0, sigma1, sigma2, delta) per axis
MAX_KNOTS = 8
KNOT_SIZE = 8
KNOTS = AXIS_BLOCK + MAX_AXES * AXIS_SIZE
EFFECT_PARAMETERS = KNOTS + MAX_AXES * MAX_KNOTS * KNOT_SIZE
PARAMETERS_PER_INSTANCE = 8
#: series of the Stribeck bump about a grid of ratios |v| / v_s, per axis (`stribeck_expansion`)
BUMP_TABLE = EFFECT_PARAMETERS + PARAMETERS_PER_INSTANCE * MAX_INSTANCES
BUMP_OCTAVES, BUMP_TERMS = 18, 8
BUMP_CELLS = 64 * BUMP_OCTAVES
BUMP_TABLE_SIZE = BUMP_CELLS * BUMP_TERMS
P_SIZE = BUMP_TABLE + MAX_AXES * BUMP_TABLE_SIZE
#: a recorded base motion follows at P_SIZE: rows of roll, pitch, yaw, p, q, r, p', q', r', ax, ay, az
BASE_COLUMNS = 12

# --- X: state
#: steps done since the start, exact in a float64 up to 2^53
STEPS = 0
#: first moment of the command inside a step, about its middle, over the step, as what delays it last wrote it
COMMAND_MOMENT = 1
POSITION, RATE, ACCELERATION, BRISTLE = 2, 4, 6, 8
#: torque at the joint after the actuator, and friction opposing the motion, means over the last step
APPLIED, FRICTION, LAGGED = 10, 12, 14
GYRO_STATE = 16
TEMPERATURE = 20
#: friction in force per axis: Ts .. delta, which follow temperature once a tick, then what `derive_friction` makes of
#: them: the speed beyond which the Stribeck bump is nothing, 1 / vs, and for one step sigma0 h / Tc and sigma1 / h
IN_FORCE = 22
BUMP_GONE_SPEED, PER_VS, RELAXATION, SIGMA1_PER_STEP = range(7, 11)
IN_FORCE_SIZE = 11
#: inertial body rates at the last step (outer x, y, z, inner x, y, z), for the gyros
BODY_RATE = 44
#: about which joint positions sine and cosine are expanded during a tick: position, sine, cosine of each axis
EXPANSION = 50
EXPANSION_SIZE = 3
#: what the drive does to a joint besides its torque (bits of `HeldBy`, as a float), and where its holding brake took
#: hold, per axis
HELD, HELD_AT = 56, 58
EFFECT_STATES = 60


def axis_block(axis: int) -> int:
    """Offset in P of an axis' block."""
    return AXIS_BLOCK + axis * AXIS_SIZE
