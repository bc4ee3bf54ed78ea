"""Arms of many joints: what the others do to one of them, from a URDF and the motion of all."""

from gimbal_hil.data.arms.arm import Arm, arm_of_urdf
from gimbal_hil.data.arms.one_joint import OneJoint, one_joint

__all__ = ["Arm", "OneJoint", "arm_of_urdf", "one_joint"]
