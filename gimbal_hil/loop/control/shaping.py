"""A reference made feasible without delay: steps become motions, motions stay as they are.

What a step adds is kept as a gap between the reference and its shaped copy, and closed by the prefilter's law within
its limits of rate and acceleration. A reference that moves smoothly opens no gap, so it is
followed exactly, slope and all.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from gimbal_hil.loop.control.layout import (
    ASKED,
    ASKED_SLOPE,
    PREFILTER_ACCELERATION,
    PREFILTER_CORNER,
    PREFILTER_GAIN,
    PREFILTER_RATE,
    SHAPED_ACCELERATION,
    SHAPED_POSITION,
    SHAPED_RATE,
    TO_COME,
    TO_COME_RATE,
)
from gimbal_hil.loop.control.pi import clamp

#: jumps below this share of what the acceleration limit moves in a tick are the sampling of a smooth motion (or of
#: straight pieces), not steps
_SAMPLING = 2.0
#: jumps up to this (rad) of a reference whose curve is known come of the news that a navigation brings, not of a step
_TOLD = 2e-3


@compiled
def start_shaping(position: float, H: np.ndarray, h: int) -> None:
    """The shaped reference begins at rest where the axis is (rad)."""
    H[h + SHAPED_POSITION] = H[h + ASKED] = position
    for state in (SHAPED_RATE, SHAPED_ACCELERATION, TO_COME, TO_COME_RATE, ASKED_SLOPE):
        H[h + state] = 0.0


@compiled
def shape_position(
    asked: float, slope: float, curve: float, step_s: float, H: np.ndarray, h: int, C: np.ndarray, c: int
) -> None:
    """Shaped position, rate and acceleration of this tick for a reference (rad), its slope (rad/s) and that one's
    (rad/s^2; NaN: by differences).
    """
    # table 5.11 allows a prefilter whose gain is not one
    asked, slope = C[c + PREFILTER_GAIN] * asked, C[c + PREFILTER_GAIN] * slope
    corner, most = C[c + PREFILTER_CORNER], C[c + PREFILTER_ACCELERATION]
    jump = asked - H[h + ASKED] - 0.5 * step_s * (H[h + ASKED_SLOPE] + slope)
    if abs(jump) > (_SAMPLING * most * step_s * step_s if math.isnan(curve) else _TOLD):
        H[h + TO_COME] += jump
    # the slope's own jump (a ramp begins) is a motion to catch up with, as well
    H[h + TO_COME_RATE] += _slope_jump(slope - H[h + ASKED_SLOPE], most * step_s)
    before, coming = H[h + SHAPED_RATE], H[h + TO_COME_RATE]
    fastest = C[c + PREFILTER_RATE]
    closing = _closing(H[h + TO_COME], -H[h + TO_COME_RATE], step_s, corner, most, fastest)
    # both together within the rate too: what the reference moves by itself is not there for the gap
    H[h + TO_COME_RATE] = -(closing if slope == 0.0 else _left_of_rate(closing, slope, fastest))
    H[h + TO_COME] += H[h + TO_COME_RATE] * step_s
    H[h + ASKED], H[h + ASKED_SLOPE] = asked, slope
    H[h + SHAPED_POSITION], H[h + SHAPED_RATE] = asked - H[h + TO_COME], slope - H[h + TO_COME_RATE]
    if math.isnan(curve):
        acceleration = (H[h + SHAPED_RATE] - before) / step_s
    else:
        acceleration = curve - (H[h + TO_COME_RATE] - coming) / step_s
    H[h + SHAPED_ACCELERATION] = clamp(acceleration, -2.0 * most, 2.0 * most)


@compiled
def _slope_jump(change: float, most: float) -> float:
    """Change of a slope (rad/s) that no motion within the acceleration limit makes in a tick; else nothing."""
    return change if abs(change) > _SAMPLING * most else 0.0


@compiled
def _left_of_rate(closing: float, slope: float, fastest: float) -> float:
    """A closing rate (rad/s) with which a reference that moves by itself stays within its rate; one that is too fast
    already is followed and no gap closed in its direction.
    """
    return clamp(closing, min(0.0, -fastest - slope), max(0.0, fastest - slope))


@compiled
def _closing(gap: float, last: float, step_s: float, corner: float, most: float, fastest: float) -> float:
    """Rate (rad/s) at which a gap (rad) is closed after a tick at `last`: the filter's own near the end, from where it
    would brake too hard the speed from which the acceleration allowed just comes to rest.
    """
    size, near = abs(gap), most / (corner * corner)
    speed = corner * size if size <= near else math.sqrt(2.0 * most * (size - 0.5 * near))
    wanted = math.copysign(min(speed, fastest), gap)
    return clamp(wanted, last - most * step_s, last + most * step_s)
