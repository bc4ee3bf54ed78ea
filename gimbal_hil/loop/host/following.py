"""Following a plan: which segment is in force, what each axis is asked for at this tick, and when a segment is over."""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from gimbal_hil.loop.control import PREFILTER_RATE, RATE_REFERENCE_LIMIT, TORQUE, Mode, clamp
from gimbal_hil.loop.host.direction import angle_between, direction_now, joints_of, looks_along, nearest_turn
from gimbal_hil.loop.host.event_ring import report
from gimbal_hil.loop.host.keyhole import elevation_beside, planned_azimuth
from gimbal_hil.loop.host.layout import (
    AFTERWARDS,
    AXES,
    AXIS_C,
    AXIS_C_SIZE,
    AXIS_G,
    AXIS_G_SIZE,
    AXIS_H,
    AXIS_H_SIZE,
    AXIS_SEGMENT,
    AXIS_SEGMENT_SIZE,
    BRAKED,
    CURVE,
    DURATION_TICKS,
    END,
    END_AXIS,
    END_CONDITIONS,
    END_HOLD_TICKS,
    END_KIND,
    END_SIZE,
    END_THRESHOLD,
    END_TICKS,
    GUARD_HIGH,
    GUARD_LOW,
    GUARD_RATE,
    GUARD_TORQUE,
    KEYHOLE_SIDE,
    LAST_TICK,
    MEASURED_POSITION,
    MEASURED_RATE,
    MODE,
    ORIGIN,
    PLAN_LENGTH,
    POINTING_ERROR,
    POSITION_HIGH,
    POSITION_LOW,
    REFERENCE,
    SEGMENT,
    SEGMENT_ID,
    SEGMENT_LABEL,
    SEGMENT_MODE,
    SEGMENT_RUNS,
    SEGMENT_SIZE,
    SEGMENT_START,
    SHAPE,
    SHAPE_PARAMETERS,
    SLOPE,
    START_VALUE,
    STEP_S,
    SWITCH_OFF,
    TOWARDS,
    TOWARDS_RATES,
    WRAP_HIGH,
    WRAP_LOW,
)
from gimbal_hil.loop.host.limits import joint_rate
from gimbal_hil.loop.host.references import reference_at, reference_time
from gimbal_hil.loop.host.states import NOTHING, AxisOff, EndKind, EventCode, HostCause, ReferenceOrigin, Shape, number

_OFF, _TORQUE, _RATE, _POSITION = number(Mode.OFF), number(Mode.TORQUE), number(Mode.RATE), number(Mode.POSITION)
_INERTIAL_RATE, _POINTING = number(Mode.INERTIAL_RATE), number(Mode.POINTING)
_BRAKED = number(AxisOff.BRAKED)
_START, _TIMETABLE = number(ReferenceOrigin.START), number(Shape.TIMETABLE)
_TWO_PI = 2.0 * math.pi
#: what a base that turns is left of the cable at either end of a planned way (rad)
_CABLE_LEFT = 0.5
_NO_END, _RATE_ABOVE, _RATE_BELOW = number(EndKind.NONE), number(EndKind.RATE_ABOVE), number(EndKind.RATE_BELOW)
_POSITION_ABOVE, _POSITION_BELOW = number(EndKind.POSITION_ABOVE), number(EndKind.POSITION_BELOW)
_SEGMENT_STARTED, _SEGMENT_ENDED = number(EventCode.SEGMENT_STARTED), number(EventCode.SEGMENT_ENDED)
_NONE, _DURATION, _END_CONDITION = number(HostCause.NONE), number(HostCause.DURATION), number(HostCause.END_CONDITION)


@compiled
def start_segment(place: int, H: np.ndarray, G: np.ndarray, plan: np.ndarray) -> None:
    """Put the plan's segment `place` in force from this tick on.

    References with origin START, and moves, go on from the reference before when the mode stays, else from where the
    axis is.
    """
    base = place * SEGMENT_SIZE
    G[SEGMENT], G[SEGMENT_START], G[SEGMENT_RUNS] = place, G[LAST_TICK], 1
    for k in range(END_CONDITIONS):
        G[END_TICKS + k] = 0
    for axis in range(AXES):
        h = AXIS_H + axis * AXIS_H_SIZE
        s = base + AXIS_SEGMENT + axis * AXIS_SEGMENT_SIZE
        mode = int(plan[s + SEGMENT_MODE])
        braked = mode == _OFF and int(plan[s + SHAPE_PARAMETERS]) == _BRAKED
        G[AXIS_G + axis * AXIS_G_SIZE + BRAKED] = 1 if braked else 0
        if mode == G[AXIS_G + axis * AXIS_G_SIZE + MODE]:
            H[h + START_VALUE] = H[h + REFERENCE]
        else:
            H[h + START_VALUE] = _measured(mode, H, axis)
    G[SEGMENT_LABEL] = int(plan[base + SEGMENT_ID])
    report(G, _SEGMENT_STARTED, place, G[SEGMENT_LABEL], NOTHING)


@compiled
def end_segment(G: np.ndarray, cause: int) -> None:
    """The segment in force is over."""
    if G[SEGMENT_RUNS] == 1:
        G[SEGMENT_RUNS] = 0
        report(G, _SEGMENT_ENDED, G[SEGMENT], G[SEGMENT_LABEL], cause)


@compiled
def has_next(G: np.ndarray) -> bool:
    """Whether the plan goes on after the segment in force."""
    return bool(G[SEGMENT] + 1 < G[PLAN_LENGTH])


@compiled
def switches_off(G: np.ndarray, plan: np.ndarray) -> bool:
    """Whether torque is to be switched off after the segment in force."""
    return bool(plan[G[SEGMENT] * SEGMENT_SIZE + AFTERWARDS] == SWITCH_OFF)


@compiled
def wanted_mode(G: np.ndarray, plan: np.ndarray, axis: int) -> int:
    """Mode that the segment in force asks of an axis; a direction is held by the position loops."""
    mode = int(plan[G[SEGMENT] * SEGMENT_SIZE + AXIS_SEGMENT + axis * AXIS_SEGMENT_SIZE + SEGMENT_MODE])
    return _POSITION if mode == _POINTING else mode


@compiled
def set_references(H: np.ndarray, G: np.ndarray, C: np.ndarray, plan: np.ndarray) -> None:
    """Reference and slope of each axis at this tick; after the end a position is held and everything else is zero."""
    first = G[SEGMENT] * SEGMENT_SIZE + AXIS_SEGMENT
    if G[SEGMENT_RUNS] == 1 and int(plan[first + SEGMENT_MODE]) == _POINTING:
        _set_direction(H, G, C, plan, first)
        return
    for axis in range(AXES):
        h, c = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE
        s = G[SEGMENT] * SEGMENT_SIZE + AXIS_SEGMENT + axis * AXIS_SEGMENT_SIZE
        mode = wanted_mode(G, plan, axis)
        if G[SEGMENT_RUNS] == 1:
            origin = H[h + START_VALUE] if int(plan[s + ORIGIN]) == _START else 0.0
            value, slope = _asked(G, C, plan, s, origin, H[h + START_VALUE])
        else:
            value, slope = (H[h + REFERENCE] if mode == _POSITION else 0.0), 0.0
        if mode == _POSITION:
            held = _within_limits(value, C, c)
            if held != value:
                value, slope = held, 0.0
        H[h + REFERENCE], H[h + SLOPE], H[h + CURVE] = value, slope, math.nan


@compiled
def _within_limits(position: float, C: np.ndarray, c: int) -> float:
    """A joint position (rad) held within soft travel and cable."""
    low, high = _travel(C, c)
    return clamp(position, low, high)


@compiled
def _travel(C: np.ndarray, c: int) -> tuple[float, float]:
    """Least and largest joint position (rad) that soft travel and cable allow."""
    return max(C[c + POSITION_LOW], C[c + WRAP_LOW]), min(C[c + POSITION_HIGH], C[c + WRAP_HIGH])


@compiled
def _asked(G: np.ndarray, C: np.ndarray, plan: np.ndarray, s: int, origin: float, start: float) -> tuple[float, float]:
    """Value and slope that the axis' block at `s` of the segment in force asks for at this tick."""
    shape, p = int(plan[s + SHAPE]), s + SHAPE_PARAMETERS
    time_s = reference_time(shape, plan, p, G[LAST_TICK], G[SEGMENT_START], C[STEP_S])
    return reference_at(shape, plan, p, origin, start, time_s)


@compiled
def _set_direction(H: np.ndarray, G: np.ndarray, C: np.ndarray, plan: np.ndarray, first: int) -> None:
    """References of both joints that look in a direction in space: azimuth and elevation of the two axes' shapes."""
    azimuth, azimuth_rate = _asked(G, C, plan, first, 0.0, 0.0)
    elevation, elevation_rate = _asked(G, C, plan, first + AXIS_SEGMENT_SIZE, 0.0, 0.0)
    d, rate, curve = direction_now(azimuth, elevation, azimuth_rate, elevation_rate, H, C)
    outer, inner = joints_of(d, rate, curve)
    stands = H[AXIS_H + MEASURED_POSITION]
    H[POINTING_ERROR] = angle_between(d, looks_along(stands, H[AXIS_H + AXIS_H_SIZE + MEASURED_POSITION]))
    H[TOWARDS_RATES], H[TOWARDS_RATES + 1], H[TOWARDS + 1] = outer[1], inner[1], inner[0]
    before = H[AXIS_H + REFERENCE] if G[AXIS_G + MODE] == _POSITION else stands
    low, high = _travel(C, AXIS_C)
    if G[LAST_TICK] == G[SEGMENT_START] and int(plan[first + SHAPE]) == _TIMETABLE:
        before = _turn_for_all(plan, first + SHAPE_PARAMETERS, azimuth, outer[0], stands, low, high)
    H[TOWARDS] = nearest_turn(outer[0], before, low, high)
    planned, azimuth_plan = planned_azimuth(d, rate, curve, stands, H, C)
    if planned:
        outer = azimuth_plan
    if H[KEYHOLE_SIDE] != 0.0:
        inner = elevation_beside(d, rate, stands, joint_rate(H, 0))
    for axis in range(AXES):
        h, c = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE
        value, slope, curved = inner if axis else outer
        if axis == 0:
            value = nearest_turn(value, before, low, high)
        held = _within_limits(value, C, c)
        if held != value:
            value, slope, curved = held, 0.0, 0.0
        if abs(slope) > C[c + RATE_REFERENCE_LIMIT] or abs(slope) > C[c + PREFILTER_RATE] > 0.0:
            # near the zenith: faster than the joint may go, so it comes after as if by steps
            slope, curved = 0.0, math.nan
        H[h + REFERENCE], H[h + SLOPE], H[h + CURVE] = value, slope, curved


@compiled
def _turn_for_all(
    plan: np.ndarray, p: int, azimuth: float, joint: float, stands: float, low: float, high: float
) -> float:
    """Outer position (rad) to begin a timetable at, so that the cable lets the joint follow all of it: on the turn
    where it `stands` if that does, else on the one that has the whole way nearest to the middle of the cable.

    `joint` is where the joint looks at the table's `azimuth` of now: both differ by the heading.
    """
    least, most, scale = math.inf, -math.inf, plan[p + 3]
    for row in range(int(plan[p + 1])):
        value = scale * plan[int(plan[p]) + row]
        least, most = min(least, value), max(most, value)
    here = nearest_turn(joint, stands, low, high)
    # without an end there is nothing to plan
    if math.isinf(low) or math.isinf(high):
        return here
    if here + least - azimuth >= low + _CABLE_LEFT and here + most - azimuth <= high - _CABLE_LEFT:
        return here
    middle = 0.5 * (low + high) - 0.5 * (least + most) + azimuth
    return joint + _TWO_PI * math.floor((middle - joint) / _TWO_PI + 0.5)


@compiled
def guard_trips(H: np.ndarray, G: np.ndarray, plan: np.ndarray) -> bool:
    """Whether an axis is outside what the segment allows it: position, joint rate, torque of the last tick."""
    for axis in range(AXES):
        h = AXIS_H + axis * AXIS_H_SIZE
        s = G[SEGMENT] * SEGMENT_SIZE + AXIS_SEGMENT + axis * AXIS_SEGMENT_SIZE
        position = H[h + MEASURED_POSITION]
        if position < plan[s + GUARD_LOW] or position > plan[s + GUARD_HIGH]:
            return True
        if abs(joint_rate(H, axis)) > plan[s + GUARD_RATE] or abs(H[h + TORQUE]) > plan[s + GUARD_TORQUE]:
            return True
    return False


@compiled
def segment_over(H: np.ndarray, G: np.ndarray, plan: np.ndarray) -> int:
    """The HostCause for which the segment in force ends with this tick, NONE while it goes on."""
    base = G[SEGMENT] * SEGMENT_SIZE
    for k in range(END_CONDITIONS):
        e = base + END + k * END_SIZE
        kind = int(plan[e + END_KIND])
        if kind == _NO_END:
            continue
        holds = _condition(kind, int(plan[e + END_AXIS]), plan[e + END_THRESHOLD], H)
        G[END_TICKS + k] = G[END_TICKS + k] + 1 if holds else 0
        if holds and G[END_TICKS + k] >= plan[e + END_HOLD_TICKS]:
            return _END_CONDITION
    duration = plan[base + DURATION_TICKS]
    return _DURATION if duration > 0.0 and G[LAST_TICK] - G[SEGMENT_START] + 1 >= duration else _NONE


@compiled
def _condition(kind: int, axis: int, threshold: float, H: np.ndarray) -> bool:
    h = AXIS_H + axis * AXIS_H_SIZE
    if kind == _RATE_ABOVE:
        return abs(joint_rate(H, axis)) > threshold
    if kind == _RATE_BELOW:
        return abs(joint_rate(H, axis)) < threshold
    if kind == _POSITION_ABOVE:
        return bool(H[h + MEASURED_POSITION] > threshold)
    if kind == _POSITION_BELOW:
        return bool(H[h + MEASURED_POSITION] < threshold)
    return bool(abs(H[h + TORQUE]) > threshold)


@compiled
def _measured(mode: int, H: np.ndarray, axis: int) -> float:
    h = AXIS_H + axis * AXIS_H_SIZE
    if mode == _POSITION:
        return float(H[h + MEASURED_POSITION])
    if mode == _RATE:
        return joint_rate(H, axis)
    if mode == _INERTIAL_RATE:
        return float(H[h + MEASURED_RATE])
    return float(H[h + TORQUE]) if mode == _TORQUE else 0.0


@compiled
def stopping_reference(H: np.ndarray, axis: int, braking_rad_s2: float, step_s: float) -> None:
    """Bring an axis' rate reference one tick nearer to rest."""
    h = AXIS_H + axis * AXIS_H_SIZE
    rate, change = H[h + REFERENCE], braking_rad_s2 * step_s
    H[h + REFERENCE] = 0.0 if abs(rate) <= change else rate - math.copysign(change, rate)
    H[h + SLOPE] = 0.0
