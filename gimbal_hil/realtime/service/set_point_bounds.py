"""Whether an axis can be where an operator wants it: a set-point that the host could only clamp is refused, with the
limit in words.
"""

from __future__ import annotations

import math

from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.settings import WIRE_TURNS, AxisSettings, DaemonSettings
from gimbal_hil.realtime.service.operator_commands import ModeName, SetPointRequest


def require_reachable(request: SetPointRequest, settings: DaemonSettings) -> None:
    """BadInputError where a value lies beyond the limits that the configuration gives its axis."""
    for name, value in zip(settings.axis_names, (request.outer, request.inner), strict=True):
        low, high, key, unit = _bounds(request.mode, settings.axes[name])
        if not low <= value <= high:
            raise BadInputError(f"set_point.{name}", f"{value:g} {unit} is beyond {key}", f"{low:g} to {high:g} {unit}")


def _bounds(mode: ModeName, axis: AxisSettings) -> tuple[float, float, str, str]:
    """Least and largest value, the key that says so, and the unit."""
    limits = axis.limits
    if mode == "torque":
        return -limits.torque_nm, limits.torque_nm, "limits.torque_nm", "N m"
    if mode in ("rate", "inertial_rate"):
        return -limits.rate_rad_s, limits.rate_rad_s, "limits.rate_rad_s", "rad/s"
    if mode == "position":
        wrap = math.inf if limits.cable_wrap_turns is None else 2.0 * math.pi * limits.cable_wrap_turns
        low = -wrap if limits.position_low_rad is None else max(-wrap, limits.position_low_rad)
        high = wrap if limits.position_high_rad is None else min(wrap, limits.position_high_rad)
        key = "limits.cable_wrap_turns" if -low == high == wrap else "limits.position_low_rad and position_high_rad"
        most = WIRE_TURNS * 2.0 * math.pi
        return (
            max(low, -most),
            min(high, most),
            key if math.isfinite(max(-low, high)) else "what the encoder can count",
            "rad",
        )
    if mode == "pointing":
        # where the joints cannot follow they stop at their limits: the base moves on
        return -2.0 * math.pi, 2.0 * math.pi, "a whole turn", "rad"
    return 0.0, 0.0, "mode off, which takes no value", ""
