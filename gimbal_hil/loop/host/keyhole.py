"""Past the zenith with an azimuth that can only turn so fast, planned from where the direction is going.

Near the zenith (or the nadir) a direction passes the axis of the azimuth on a nearly straight line at a speed v and a
distance r, both sines of angles in base axes. With t from the closest approach the exact azimuth is atan(v t / r) away
from its middle: half a turn for small r, faster than the joint may go. The azimuth then turns at a steady rate W, as
much before the closest approach as after it: min(W abs(t), atan(v abs(t) / r)), which is the exact one wherever that is
feasible. The elevation follows the azimuth as it is, over the top where its travel allows. The line of sight is then at
most max over t of v t cos(W t) = 0.56 v / W off, a third of what it is when the azimuth comes after.

That is foreseen for a straight line only. Where the direction would turn round before the closest approach, as it does
above an aircraft in turbulence, the azimuth comes after: half a turn made for nothing costs more.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import sine_cosine
from gimbal_hil.loop.control import PREFILTER_RATE, RATE_REFERENCE_LIMIT
from gimbal_hil.loop.host.direction import Vector
from gimbal_hil.loop.host.layout import AXIS_C, KEYHOLE_SIDE

_HALF_TURN_PI = 0.5 * math.pi
#: share of the azimuth's largest rate that is planned with; the rest catches up with what was not foreseen
_SHARE = 0.8
#: the plan ends where the azimuth has come this near to the exact one (rad), or the direction this far from the zenith
_CAUGHT_UP, _FAR = 0.05, 0.3


@compiled
def planned_azimuth(
    d: Vector, rate: Vector, curve: Vector, measured: float, H: np.ndarray, C: np.ndarray
) -> tuple[bool, Vector]:
    """Whether an azimuth is planned past the zenith at this tick, and then its position (rad), rate (rad/s) and NaN.

    `d`, `rate` and `curve` are the direction in base axes and its derivatives, `measured` is where the outer joint
    stands (rad).
    """
    fastest = _SHARE * _largest_rate(C)
    speed, level = math.sqrt(rate[0] * rate[0] + rate[1] * rate[1]), math.sqrt(d[0] * d[0] + d[1] * d[1])
    if level > _FAR or speed == 0.0 or (level * fastest > _HALF_TURN_PI * speed and H[KEYHOLE_SIDE] == 0.0):
        H[KEYHOLE_SIDE] = 0.0
        return False, (0.0, 0.0, 0.0)
    # distance signed by which way round the azimuth turns, and time since the closest approach
    distance = (d[0] * rate[1] - d[1] * rate[0]) / speed
    since = (d[0] * rate[0] + d[1] * rate[1]) / (speed * speed)
    if math.sqrt(curve[0] * curve[0] + curve[1] * curve[1]) * abs(since) > speed:
        H[KEYHOLE_SIDE] = 0.0
        return False, (0.0, 0.0, 0.0)
    # the way round stays what it was when the plan began, or it would turn back where the line is nearly straight above
    side = H[KEYHOLE_SIDE] if H[KEYHOLE_SIDE] != 0.0 else math.copysign(1.0, distance)
    exact, turned = math.atan2(speed * abs(since), abs(distance)), fastest * abs(since)
    if turned >= exact:
        azimuth = math.atan2(d[1], d[0])
        if abs(math.sin(0.5 * (azimuth - measured))) < 0.5 * _CAUGHT_UP:
            H[KEYHOLE_SIDE] = 0.0
        return False, (0.0, 0.0, 0.0)
    H[KEYHOLE_SIDE] = side
    middle = math.atan2(rate[1], rate[0]) - side * _HALF_TURN_PI
    return True, (middle + side * math.copysign(turned, since), side * fastest, math.nan)


@compiled
def elevation_beside(d: Vector, rate: Vector, azimuth: float, azimuth_rate: float) -> Vector:
    """Elevation (rad), rate (rad/s) and NaN of the inner joint that looks nearest to a direction while the outer one is
    at an azimuth (rad) that does not lead there.
    """
    s, c = sine_cosine(azimuth)
    ahead, across = d[0] * c + d[1] * s, d[1] * c - d[0] * s
    slope = rate[0] * c + rate[1] * s + azimuth_rate * across
    square = ahead * ahead + d[2] * d[2]
    return math.atan2(-d[2], ahead), (d[2] * slope - ahead * rate[2]) / square, math.nan


@compiled
def _largest_rate(C: np.ndarray) -> float:
    limit, prefilter = C[AXIS_C + RATE_REFERENCE_LIMIT], C[AXIS_C + PREFILTER_RATE]
    return float(prefilter if 0.0 < prefilter < limit else limit)
