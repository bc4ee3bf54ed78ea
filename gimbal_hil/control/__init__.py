"""The control law as pure compiled functions: state in `H`, parameters in `C`, nothing else."""

from gimbal_hil.control import layout
from gimbal_hil.control.cascade import axis_torque, enter_mode
from gimbal_hil.control.compensation import (
    GRAVITY_M_S2,
    base_rates,
    friction_torque,
    gravity_in_base,
    gravity_torques,
    has_moments,
)
from gimbal_hil.control.kalman import ObservedJoint
from gimbal_hil.control.layout import AntiWindup, Mode
from gimbal_hil.control.model_torques import modelled_friction, rigid_torques
from gimbal_hil.control.observer import observe, observed_torque, remember_torque, start_observing
from gimbal_hil.control.pi import clamp, next_integral
from gimbal_hil.control.shaping import shape_position, start_shaping
from gimbal_hil.control.staleness import (
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
    "axis_torque",
    "base_rates",
    "clamp",
    "enter_mode",
    "fade_model",
    "friction_torque",
    "gravity_in_base",
    "gravity_torques",
    "has_moments",
    "is_observed",
    "judge_model",
    "layout",
    "leave_observer",
    "modelled_friction",
    "next_integral",
    "observe",
    "observed_torque",
    "remember_torque",
    "rigid_torques",
    "shape_position",
    "start_observing",
    "start_shaping",
]
