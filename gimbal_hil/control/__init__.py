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
from gimbal_hil.control.layout import AntiWindup, Mode
from gimbal_hil.control.pi import clamp, next_integral

__all__ = [
    "GRAVITY_M_S2",
    "AntiWindup",
    "Mode",
    "axis_torque",
    "base_rates",
    "clamp",
    "enter_mode",
    "friction_torque",
    "gravity_in_base",
    "gravity_torques",
    "has_moments",
    "layout",
    "next_integral",
]
