"""The control law as pure compiled functions: state in `H`, parameters in `C`, nothing else."""

from gimbal_hil.loop.control import layout
from gimbal_hil.loop.control.cascade import axis_torque, enter_mode
from gimbal_hil.loop.control.compensation import (
    GRAVITY_M_S2,
    base_rates,
    friction_torque,
    gravity_in_base,
    gravity_torques,
    has_moments,
)
from gimbal_hil.loop.control.friction_levels import adapt_friction, friction_at, has_new_levels, modelled_friction
from gimbal_hil.loop.control.kalman import ObservedJoint
from gimbal_hil.loop.control.layout import AntiWindup, Mode
from gimbal_hil.loop.control.model_torques import rigid_torques
from gimbal_hil.loop.control.observer import observe, observed_torque, remember_torque, start_observing
from gimbal_hil.loop.control.pi import clamp, next_integral
from gimbal_hil.loop.control.position_torque import bin_of, learn, learned_torque, named_torque
from gimbal_hil.loop.control.shaping import shape_position, start_shaping
from gimbal_hil.loop.control.staleness import (
    SHAKES,
    TURNED_RIGHT,
    TURNED_STALE,
    UNCHANGED,
    fade_model,
    is_observed,
    judge_model,
    leave_observer,
)

__all__ = [
    "GRAVITY_M_S2",
    "SHAKES",
    "TURNED_RIGHT",
    "TURNED_STALE",
    "UNCHANGED",
    "AntiWindup",
    "Mode",
    "ObservedJoint",
    "adapt_friction",
    "axis_torque",
    "base_rates",
    "bin_of",
    "clamp",
    "enter_mode",
    "fade_model",
    "friction_at",
    "friction_torque",
    "gravity_in_base",
    "gravity_torques",
    "has_moments",
    "has_new_levels",
    "is_observed",
    "judge_model",
    "layout",
    "learn",
    "learned_torque",
    "leave_observer",
    "modelled_friction",
    "named_torque",
    "next_integral",
    "observe",
    "observed_torque",
    "remember_torque",
    "rigid_torques",
    "shape_position",
    "start_observing",
    "start_shaping",
]
