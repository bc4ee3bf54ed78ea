"""Joint positions and MAVLink's attitudes.

The antenna's axes are x forward (north), y left (west), z up; MAVLink's are x forward (north), y right (east), z down.
So MAVLink's yaw (clockwise seen from above) is minus the outer joint, and its pitch (nose up) minus the inner one, on a
level base that looks north. Source: MAVLink common message set, GIMBAL_DEVICE_ATTITUDE_STATUS.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from scipy.spatial.transform import Rotation

#: a quaternion that is further from unit length than this is no attitude
_LENGTH = 0.05
#: nearer to straight up or down than this the yaw is that of nothing
_NO_YAW = 1e-6


def quaternion(
    joints_rad: Sequence[float], base_rad: Sequence[float] | None, from_north: bool
) -> tuple[float, float, float, float]:
    """MAVLink's attitude (w, x, y, z) of the antenna at those joint positions (outer, inner).

    `base_rad` is the attitude of the base (roll, pitch, yaw of R_eb = Rz(yaw) Ry(pitch) Rx(roll)), level where it is
    not known. Roll and pitch are against the horizon; yaw is from north, or else from where the base looks.
    """
    roll, pitch, yaw = base_rad or (0.0, 0.0, 0.0)
    base = Rotation.from_euler("ZYX", [yaw if from_north else 0.0, pitch, roll])
    x, y, z, w = (base * Rotation.from_euler("ZY", list(joints_rad))).as_quat()
    return float(w), float(x), float(-y), float(-z)


def direction_rad(q: Sequence[float], outer_rad: float) -> tuple[float, float] | None:
    """Joint positions (outer, inner) from a level base that looks north, at which the boresight points as the attitude
    `q` (w, x, y, z) says; roll about the boresight has no joint. Straight up and down the outer joint stays at
    `outer_rad`. None where `q` is no attitude.
    """
    length = math.sqrt(sum(value * value for value in q))
    if not math.isfinite(length) or abs(length - 1.0) > _LENGTH:
        return None
    w, x, y, z = q
    ahead, left, up = Rotation.from_quat([x, -y, -z, w]).apply([1.0, 0.0, 0.0])
    outer = math.atan2(left, ahead) if math.hypot(ahead, left) > _NO_YAW else outer_rad
    return outer, -math.asin(max(-1.0, min(1.0, float(up))))


def nearest_turn(angle_rad: float, to_rad: float, low_rad: float, high_rad: float) -> float:
    """The angle plus as many whole turns as bring it nearest to `to_rad` inside its limits; as it is where no turn
    does.
    """
    turn = 2.0 * math.pi
    nearest = angle_rad + turn * round((to_rad - angle_rad) / turn)
    reachable = [one for one in (nearest, nearest - turn, nearest + turn, angle_rad) if low_rad <= one <= high_rad]
    return min(reachable, key=lambda one: abs(one - to_rad), default=angle_rad)
