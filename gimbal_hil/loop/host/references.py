"""Reference shapes, each a closed form of the time since the segment began, so that any tick can be computed on its
own.

Parameters per shape (in the mode's unit u, times in s):

    HOLD       value
    RAMP       value, slope (u/s), span (u; the ramp ends that far from where it began, inf without)
    SINE       value, amplitude, frequency (Hz), phase (rad)
    CHIRP      value, amplitude, first frequency (Hz), growth ln(last/first)/duration (1/s), duration
    TRAPEZOID  target, largest slope (u/s), largest curvature (u/s^2)
    SMOOTH     target, duration
    PULSES     value, amplitude, period, width, 1 when every other pulse is negative, number of pulses
    TABLE      offset in the plan, rows, seconds per row, scale
    TIMETABLE  the same, and the tick of the first row (-1 - n: n ticks before the segment's own first)

With origin START, `value` and `target` count from the start value.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import sine_cosine
from gimbal_hil.loop.host.states import Shape, number

_HOLD, _RAMP, _SINE, _CHIRP = number(Shape.HOLD), number(Shape.RAMP), number(Shape.SINE), number(Shape.CHIRP)
_TRAPEZOID, _SMOOTH, _PULSES = number(Shape.TRAPEZOID), number(Shape.SMOOTH), number(Shape.PULSES)
_TIMETABLE = number(Shape.TIMETABLE)
_TWO_PI = 2.0 * math.pi


@compiled
def reference_at(
    shape: int, plan: np.ndarray, p: int, origin: float, start: float, time_s: float
) -> tuple[float, float]:
    """Value and slope of a reference `time_s` after its segment began.

    The shape's parameters are in `plan` from `p` on; `origin` is added to values and targets; moves begin at `start`.
    """
    if shape == _HOLD:
        return origin + plan[p], 0.0
    if shape == _RAMP:
        return _ramp(origin + plan[p], plan[p + 1], plan[p + 2], time_s)
    if shape == _SINE:
        angle = _TWO_PI * plan[p + 2] * time_s + plan[p + 3]
        sine, cosine = sine_cosine(angle)
        return origin + plan[p] + plan[p + 1] * sine, plan[p + 1] * _TWO_PI * plan[p + 2] * cosine
    if shape == _CHIRP:
        return _chirp(origin + plan[p], plan[p + 1], plan[p + 2], plan[p + 3], min(time_s, plan[p + 4]))
    if shape == _TRAPEZOID:
        return _trapezoid(start, origin + plan[p], plan[p + 1], plan[p + 2], time_s)
    if shape == _SMOOTH:
        return _smooth(start, origin + plan[p], plan[p + 1], time_s)
    if shape == _PULSES:
        return _pulses(origin + plan[p], plan[p + 1], plan[p + 2], plan[p + 3], plan[p + 4], plan[p + 5], time_s)
    if shape == _TIMETABLE:
        return _timetable(plan, int(plan[p]), int(plan[p + 1]), plan[p + 2], plan[p + 3], origin, time_s)
    return _table(plan, int(plan[p]), int(plan[p + 1]), plan[p + 2], plan[p + 3], origin, time_s)


@compiled
def reference_time(shape: int, plan: np.ndarray, p: int, tick: int, start_tick: int, step_s: float) -> float:
    """Time (s) that a shape counts at a tick of a segment that began at `start_tick`."""
    first = start_tick
    if shape == _TIMETABLE:
        first = plan[p + 4] if plan[p + 4] >= 0.0 else start_tick + 1.0 + plan[p + 4]
    return (tick - first) * step_s


@compiled
def _ramp(value: float, slope: float, span: float, time_s: float) -> tuple[float, float]:
    if abs(slope) * time_s >= span:
        return value + math.copysign(span, slope), 0.0
    return value + slope * time_s, slope


@compiled
def _chirp(value: float, amplitude: float, first_hz: float, growth: float, time_s: float) -> tuple[float, float]:
    """Exponential sweep: equal time per octave; growth 0 is a plain sine."""
    frequency = first_hz * math.exp(growth * time_s)
    # expm1, because a growth of next to nothing must not lose the cycles in rounding
    cycles = first_hz * math.expm1(growth * time_s) / growth if growth != 0.0 else first_hz * time_s
    sine, cosine = sine_cosine(_TWO_PI * cycles)
    return value + amplitude * sine, amplitude * _TWO_PI * frequency * cosine


@compiled
def _trapezoid(start: float, target: float, top: float, curvature: float, time_s: float) -> tuple[float, float]:
    """Fastest move from rest to rest within a largest slope and curvature; a triangle when it is too short to reach the
    slope.
    """
    distance = abs(target - start)
    side = math.copysign(1.0, target - start)
    rise_s = min(top / curvature, math.sqrt(distance / curvature))
    slope = curvature * rise_s
    if slope <= 0.0:
        return target, 0.0
    total_s = distance / slope + rise_s
    if time_s >= total_s:
        return target, 0.0
    if time_s < rise_s:
        return start + side * 0.5 * curvature * time_s * time_s, side * curvature * time_s
    left_s = total_s - time_s
    if left_s < rise_s:
        return target - side * 0.5 * curvature * left_s * left_s, side * curvature * left_s
    return start + side * slope * (time_s - 0.5 * rise_s), side * slope


@compiled
def _smooth(start: float, target: float, duration_s: float, time_s: float) -> tuple[float, float]:
    """Move of least jerk from rest to rest (Flash and Hogan 1985)."""
    if time_s >= duration_s:
        return target, 0.0
    x = time_s / duration_s
    share = x * x * x * (10.0 - x * (15.0 - 6.0 * x))
    slope = 30.0 * x * x * (1.0 - x) * (1.0 - x) / duration_s
    return start + (target - start) * share, (target - start) * slope


@compiled
def _pulses(
    value: float, amplitude: float, period_s: float, width_s: float, alternating: float, count: float, time_s: float
) -> tuple[float, float]:
    # half a microsecond forward, so that an edge on a tick is not decided by the last bit of the division
    number = math.floor((time_s + 5e-7) / period_s)
    if number >= count or time_s + 5e-7 - number * period_s >= width_s:
        return value, 0.0
    if alternating > 0.0 and number - 2.0 * math.floor(0.5 * number) > 0.0:
        return value - amplitude, 0.0
    return value + amplitude, 0.0


@compiled
def _table(
    plan: np.ndarray, first: int, rows: int, row_s: float, scale: float, origin: float, time_s: float
) -> tuple[float, float]:
    """Rows joined by straight lines; the last one holds."""
    place = time_s / row_s
    if place >= rows - 1:
        return origin + scale * plan[first + rows - 1], 0.0
    row = int(place)
    here, step = plan[first + row], plan[first + row + 1] - plan[first + row]
    return origin + scale * (here + (place - row) * step), scale * step / row_s


@compiled
def _timetable(
    plan: np.ndarray, first: int, rows: int, row_s: float, scale: float, origin: float, time_s: float
) -> tuple[float, float]:
    """Rows joined by cubics whose slopes are those of the rows beside them (Catmull and Rom 1974); held before the
    first and after the last.
    """
    place = time_s / row_s
    if place < 0.0:
        return origin + scale * plan[first], 0.0
    if place >= rows - 1:
        return origin + scale * plan[first + rows - 1], 0.0
    row = int(place)
    x = place - row
    a, b = plan[first + row], plan[first + row + 1]
    # beyond either end the table goes on straight
    before = plan[first + row - 1] if row > 0 else 2.0 * a - b
    after = plan[first + row + 2] if row + 2 < rows else 2.0 * b - a
    m, n, d = 0.5 * (b - before), 0.5 * (after - a), b - a
    c2, c3 = 3.0 * d - 2.0 * m - n, m + n - 2.0 * d
    value, slope = a + x * (m + x * (c2 + x * c3)), m + x * (2.0 * c2 + 3.0 * x * c3)
    return origin + scale * value, scale * slope / row_s
