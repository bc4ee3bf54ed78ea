"""Whether what the sensors say can be: gyro against encoder over a window, a gyro that repeats itself, feedback that
tells nothing new behind live counters or under torque, positions that no axis can have come to, and motion against the
torque that should have made it.

Filled in with every feedback set; `implausible` judges it while torque is on.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from gimbal_hil.loop.control import TORQUE, gravity_torques
from gimbal_hil.loop.host.layout import (
    AXES,
    AXIS_C,
    AXIS_C_SIZE,
    AXIS_G,
    AXIS_G_SIZE,
    AXIS_H,
    AXIS_H_SIZE,
    BASE_GRAVITY,
    BASE_RATE,
    DEBOUNCE_TICKS,
    DEVICE_TICK,
    DISTURBANCE,
    DRIFT,
    DRIFT_KEPT,
    DRIFT_SHARE,
    DRIVE_LIMITS,
    EFFORT,
    ENCODER_SAME,
    EXPECTED_INERTIA,
    EXPECTED_MOMENT,
    EXPECTS_WEIGHT,
    GYRO_QUIET_CHANGES,
    GYRO_QUIET_TICKS,
    GYRO_SAME,
    GYRO_STEP,
    IMPULSE,
    LAST_JOINT_RATE,
    LAST_POSITION,
    LAST_RATE,
    LAST_RATE_CHANGE,
    LAST_SEQUENCE,
    LATE_IMPULSE,
    LATE_S,
    LONG_DRIFT,
    LONG_KEPT,
    LONG_PATH,
    LONG_WINDOW_S,
    MAX_DRIFT,
    MEASURED_POSITION,
    MEASURED_RATE,
    MODE,
    MODEL_SHARE,
    MOMENTUM,
    MOMENTUM_KEPT,
    MOMENTUM_WINDOW_S,
    PATH,
    PEAK_TORQUE,
    PLACE,
    PULL,
    QUIET_MOMENTUM,
    REPEATS,
    REST_RATE,
    SEEN_MOMENTUM,
    SENT_SEQUENCE,
    STATUS_SAME,
    STEP_S,
    STILL_COUNT,
    STUCK_TICKS,
)
from gimbal_hil.loop.host.repeating import forget_said, watch_repeats
from gimbal_hil.loop.host.states import HostCause, number

_NONE, _DRIFT, _STUCK = number(HostCause.NONE), number(HostCause.SENSOR_DRIFT), number(HostCause.GYRO_STUCK)
_FROZEN, _RUNAWAY = number(HostCause.FEEDBACK_FROZEN), number(HostCause.RUNAWAY)
#: a jump, rad: beyond the way that the rates of both samples explain and two periods of jitter, more than the coarsest
#: encoder steps; across a silence, more than an axis creeps while it is let go
_JUMP_RAD, _JITTER_PERIODS, _JUMP_IN_SILENCE_RAD = 0.05, 2.0, 0.25
#: s: an axis under a torque that it cannot hold against has moved by some counts of its encoder after so long
_MOVED_AFTER_S = 0.1
#: what may hold an axis still is what was against it while its sensors told something new, some times as much, and a
#: share of the disturbance at least
_HELD, _LEAST_HELD = 2.0, 0.1
#: PLACE
_HEARD, _JUMPED = 1, 2
#: a gyro with noise is known by it: in half of at least so many samples taken at rest without torque it leaves the
#: line through the two before by so many of its steps, as no axis that swings does; counting ends
_QUIET_LEAST, _QUIET_MOST, _NOISE_STEPS = 10, 10000, 2.5
#: a motor that turns the wrong way: how near the torque turned round must come to what was gained, by how much that has
#: grown meanwhile, from which share of the allowance on, and in how many windows quiet is forgotten
_NEAR, _GROWN, _EARLY, _QUIET_WINDOWS = 0.25, 8.0, 0.25, 10.0
_INNER = AXIS_H + AXIS_H_SIZE
_MOMENTS = (AXIS_C + EXPECTED_MOMENT, AXIS_C + AXIS_C_SIZE + EXPECTED_MOMENT)


@compiled
def watch_status(mail: np.ndarray, G: np.ndarray) -> None:
    """Count the feedback sets in a row whose device tick stood still."""
    tick = mail[m.DRIVE_STATUS_TICK]
    G[STATUS_SAME] = G[STATUS_SAME] + 1 if tick == G[DEVICE_TICK] else 0
    G[DEVICE_TICK] = tick


@compiled
def watch_sensors(H: np.ndarray, G: np.ndarray, C: np.ndarray, begin: bool, ticks: int) -> None:
    """Take in a fresh sample, `ticks` of the antenna after the one before; `begin` when there was none for long. Call
    before LAST_POSITION moves on.

    DRIFT: what encoder and gyro have moved apart (rad), forgotten with the window's time constant; PATH: how far the
    axis went meanwhile; LONG_DRIFT, LONG_PATH: likewise over a long one, where both are numbers of one sensor. Over a
    short window, in N m s: MOMENTUM that the axis gained beyond the impulse of its torque
    and its weight, IMPULSE of its torque, EFFORT, that of the torque's size, LATE_IMPULSE: how far MOMENTUM may be off
    where torques act later than they were asked for. PEAK_TORQUE: the largest size (N m). SEEN_MOMENTUM: the largest
    size of MOMENTUM while the sensors told something new, from the first motion on; never forgotten.
    """
    dt = C[STEP_S] * ticks
    weights = _weights(H, G, C)
    drift_kept, drift_new = _window(C[DRIFT_KEPT], ticks)
    long_kept, long_new = _window(C[LONG_KEPT], ticks)
    kept, new = _window(C[MOMENTUM_KEPT], ticks)
    # a torque acts some ticks after it was asked for; later where the drive's echo is, or where much came at once
    unheard = (G[SENT_SEQUENCE] - G[LAST_SEQUENCE]) & m.SET_POINT_SEQUENCE_HIGH
    late_s = max(C[LATE_S], C[STEP_S] * (max(unheard, ticks) + 1))
    for axis in range(AXES):
        h, c, g = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE, AXIS_G + axis * AXIS_G_SIZE
        rate = H[h + MEASURED_RATE]
        joint = rate - H[h + BASE_RATE]
        H[h + PULL] = abs(weights[axis])
        _watch_place(H, G, C, axis, begin, ticks)
        if begin:
            H[h + DRIFT] = H[h + PATH] = H[h + LONG_DRIFT] = H[h + LONG_PATH] = 0.0
            _forget_momentum(H, h)
            G[g + GYRO_SAME] = G[g + ENCODER_SAME] = G[g + STILL_COUNT] = 0
            H[h + LAST_RATE_CHANGE] = np.nan
            forget_said(G, axis)
        else:
            moved, turned = H[h + MEASURED_POSITION] - H[h + LAST_POSITION], 0.5 * (joint + H[h + LAST_JOINT_RATE]) * dt
            H[h + DRIFT] = drift_kept * H[h + DRIFT] + drift_new * (moved - turned)
            H[h + PATH] = drift_kept * H[h + PATH] + drift_new * max(abs(moved), abs(turned))
            H[h + LONG_DRIFT] = long_kept * H[h + LONG_DRIFT] + long_new * (moved - turned)
            H[h + LONG_PATH] = long_kept * H[h + LONG_PATH] + long_new * max(abs(moved), abs(turned))
            impulse = _acting_torque(H, G, axis) * dt
            gained = C[c + EXPECTED_INERTIA] * (rate - H[h + LAST_RATE]) - impulse - weights[axis] * dt
            H[h + MOMENTUM] = kept * H[h + MOMENTUM] + new * gained
            H[h + IMPULSE] = kept * H[h + IMPULSE] + new * impulse
            H[h + EFFORT] = kept * H[h + EFFORT] + new * abs(impulse)
            H[h + PEAK_TORQUE] = max(C[MOMENTUM_KEPT] * H[h + PEAK_TORQUE], abs(H[h + TORQUE]))
            H[h + LATE_IMPULSE] = max(C[MOMENTUM_KEPT] * H[h + LATE_IMPULSE], late_s * H[h + PEAK_TORQUE])
            _watch_quiet(H, C, h)
            if G[g + MODE] == 0:
                # what moves an axis that is off is not this host's torque
                _forget_momentum(H, h)
            changed = rate != H[h + LAST_RATE]
            G[g + GYRO_SAME] = 0 if changed else G[g + GYRO_SAME] + 1
            G[g + ENCODER_SAME] = 0 if moved != 0.0 else G[g + ENCODER_SAME] + 1
            watch_repeats(H[h + MEASURED_POSITION], rate, H, G, axis)
            still = (moved == 0.0 and not changed) or G[g + REPEATS] == 1
            if not still and (H[h + SEEN_MOMENTUM] > 0.0 or abs(joint) > C[c + REST_RATE]):
                H[h + SEEN_MOMENTUM] = max(H[h + SEEN_MOMENTUM], abs(H[h + MOMENTUM]))
            beyond = abs(_acting_torque(H, G, axis) + weights[axis]) * MOMENTUM_WINDOW_S > _held(H, C, h, c)
            G[g + STILL_COUNT] = G[g + STILL_COUNT] + 1 if still and beyond and C[c + DISTURBANCE] > 0.0 else 0
            _watch_noise(H, G, C, axis, ticks)
        H[h + LAST_RATE], H[h + LAST_JOINT_RATE] = rate, joint


@compiled
def _watch_noise(H: np.ndarray, G: np.ndarray, C: np.ndarray, axis: int, ticks: int) -> None:
    """Count the samples at rest in which a gyro shows noise. That its rate changes is none: an axis that is let go
    swings on its bristles, and a drive without noise then repeats itself at every constant rate.
    """
    h, c, g = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE, AXIS_G + axis * AXIS_G_SIZE
    rate = H[h + MEASURED_RATE]
    size = abs(rate - H[h + LAST_RATE])
    change = rate - H[h + LAST_RATE] if ticks == 1 else np.nan
    bend = abs(change - H[h + LAST_RATE_CHANGE])
    if size > 0.0 and (H[h + GYRO_STEP] == 0.0 or size < H[h + GYRO_STEP]):
        H[h + GYRO_STEP] = size
    H[h + LAST_RATE_CHANGE] = change
    if np.isnan(bend) or G[g + MODE] != 0 or abs(rate) >= C[c + REST_RATE] or G[g + GYRO_QUIET_TICKS] >= _QUIET_MOST:
        return
    G[g + GYRO_QUIET_TICKS] += 1
    G[g + GYRO_QUIET_CHANGES] += 1 if bend > 0.0 and bend >= _NOISE_STEPS * H[h + GYRO_STEP] else 0


@compiled
def _held(H: np.ndarray, C: np.ndarray, h: int, c: int) -> float:
    """Impulse (N m s) within the window against which an axis may stand still without a sign of life: friction, load
    and wind as they were seen, some times as much; until it has moved, the whole disturbance that is allowed for.
    """
    seen, most = H[h + SEEN_MOMENTUM], C[c + DISTURBANCE]
    return float(min(most, max(_HELD * seen, _LEAST_HELD * most)) if seen > 0.0 else most)


@compiled
def _watch_place(H: np.ndarray, G: np.ndarray, C: np.ndarray, axis: int, begin: bool, ticks: int) -> None:
    """Latch a position to which the axis cannot have gone from the one before: an encoder that jumps or has lost its
    zero. Only an operator's reset takes it as the place where the axis is (`accept_places`).
    """
    h, g = AXIS_H + axis * AXIS_H_SIZE, AXIS_G + axis * AXIS_G_SIZE
    if G[g + PLACE] == 0:
        G[g + PLACE] = _HEARD
        return
    joint, before = H[h + MEASURED_RATE] - H[h + BASE_RATE], H[h + LAST_JOINT_RATE]
    moved, dt = H[h + MEASURED_POSITION] - H[h + LAST_POSITION], C[STEP_S] * ticks
    if begin:
        beyond = abs(moved) - max(abs(joint), abs(before)) * dt > _JUMP_IN_SILENCE_RAD
    else:
        jitter = _JITTER_PERIODS * C[STEP_S] * max(abs(joint), abs(before))
        beyond = abs(moved - 0.5 * (joint + before) * dt) > _JUMP_RAD + jitter
    if beyond:
        G[g + PLACE] = _JUMPED


@compiled
def has_jumped(G: np.ndarray) -> bool:
    """Whether an axis is not where it can be, and nobody has accepted that."""
    return bool(G[AXIS_G + PLACE] == _JUMPED or G[AXIS_G + AXIS_G_SIZE + PLACE] == _JUMPED)


@compiled
def accept_places(H: np.ndarray, G: np.ndarray) -> None:
    """Take both axes as being where they say, whatever has moved apart until now."""
    for axis in range(AXES):
        H[AXIS_H + axis * AXIS_H_SIZE + LONG_DRIFT] = 0.0
        G[AXIS_G + axis * AXIS_G_SIZE + PLACE] = min(G[AXIS_G + axis * AXIS_G_SIZE + PLACE], _HEARD)


@compiled
def _window(kept: float, ticks: int) -> tuple[float, float]:
    """What a window that keeps a share of `kept` from tick to tick has left after so many ticks: of what it held, and
    of what came evenly within them.
    """
    if ticks == 1:
        return kept, 1.0
    left = kept**ticks
    return left, (1.0 - left) / (ticks * (1.0 - kept))


@compiled
def implausible(H: np.ndarray, G: np.ndarray, C: np.ndarray, axis: int) -> int:
    """The HostCause that the sensors of an axis give to stop without them, NONE when all is well."""
    h, c, g = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE, AXIS_G + axis * AXIS_G_SIZE
    if G[STATUS_SAME] >= C[DEBOUNCE_TICKS]:
        return _FROZEN
    if G[g + STILL_COUNT] * C[STEP_S] >= _MOVED_AFTER_S:
        return _FROZEN
    if C[c + STUCK_TICKS] > 0.0 and G[g + GYRO_SAME] >= C[c + STUCK_TICKS] and _is_noisy(G, g):
        return _FROZEN if G[g + ENCODER_SAME] >= C[c + STUCK_TICKS] else _STUCK
    # one gyro reads a part of the other's rate, and its scale is not exact
    path = H[AXIS_H + PATH] + H[AXIS_H + AXIS_H_SIZE + PATH]
    if abs(H[h + DRIFT]) > C[c + MAX_DRIFT] + C[DRIFT_SHARE] * path:
        return _DRIFT
    if C[LONG_KEPT] > 0.0 and H[h + GYRO_STEP] > 0.0 and _parts_slowly(H, C, h, c):
        return _DRIFT
    if C[c + EXPECTED_INERTIA] == 0.0:
        return _NONE
    gained, late = abs(H[h + MOMENTUM]), H[h + LATE_IMPULSE]
    if gained > C[c + DISTURBANCE] + C[MODEL_SHARE] * H[h + EFFORT] + late:
        return _RUNAWAY
    # nothing but a motor that turns the wrong way makes it grow so far while the torque turned round explains it
    grown = gained > _EARLY * C[c + DISTURBANCE] + late and gained > _GROWN * H[h + QUIET_MOMENTUM]
    return _RUNAWAY if grown and _is_turned_round(H, h) else _NONE


@compiled
def _parts_slowly(H: np.ndarray, C: np.ndarray, h: int, c: int) -> bool:
    """Whether position and rate of one sensor move apart for longer than the short window remembers: by more than a
    rate that is rounded to its steps explains.
    """
    path = H[AXIS_H + LONG_PATH] + H[AXIS_H + AXIS_H_SIZE + LONG_PATH]
    rounded = H[h + GYRO_STEP] * C[LONG_WINDOW_S]
    return bool(abs(H[h + LONG_DRIFT]) > C[c + MAX_DRIFT] + C[DRIFT_SHARE] * path + rounded)


@compiled
def _is_turned_round(H: np.ndarray, h: int) -> bool:
    """Whether the torque turned round would explain what an axis gained."""
    return bool(abs(H[h + MOMENTUM] + 2.0 * H[h + IMPULSE]) <= _NEAR * abs(H[h + MOMENTUM]))


@compiled
def _watch_quiet(H: np.ndarray, C: np.ndarray, h: int) -> None:
    """QUIET_MOMENTUM: largest size of MOMENTUM (N m s) that the torque turned round did not explain, forgotten slowly.

    A push, too, is for a moment what the torque turned round would make, while the loop takes it up; until then it has
    become half as large as it will be.
    """
    H[h + QUIET_MOMENTUM] *= 1.0 - (1.0 - C[MOMENTUM_KEPT]) / _QUIET_WINDOWS
    if not _is_turned_round(H, h):
        H[h + QUIET_MOMENTUM] = max(H[h + QUIET_MOMENTUM], abs(H[h + MOMENTUM]))


@compiled
def _forget_momentum(H: np.ndarray, h: int) -> None:
    H[h + MOMENTUM] = H[h + IMPULSE] = H[h + EFFORT] = H[h + QUIET_MOMENTUM] = 0.0
    H[h + PEAK_TORQUE] = H[h + LATE_IMPULSE] = 0.0


@compiled
def _acting_torque(H: np.ndarray, G: np.ndarray, axis: int) -> float:
    """The torque (N m) asked of an axis, or what the drive says that it makes of it: beyond its limits of travel and
    rate it cuts what leads on.
    """
    h = AXIS_H + axis * AXIS_H_SIZE
    torque, limits = H[h + TORQUE], G[DRIVE_LIMITS]
    if limits == 0:
        return float(torque)
    side = m.LIMIT_FLAGS_OUTER_TRAVEL_HIGH if torque > 0.0 else m.LIMIT_FLAGS_OUTER_TRAVEL_LOW
    too_fast = limits & (m.LIMIT_FLAGS_OUTER_RATE << axis) and torque * (H[h + MEASURED_RATE] - H[h + BASE_RATE]) > 0.0
    return 0.0 if too_fast or limits & (side << (2 * axis)) else float(torque)


@compiled
def _weights(H: np.ndarray, G: np.ndarray, C: np.ndarray) -> tuple[float, float]:
    """Torques (N m) of both bodies' weight about their axes on the base as it stands and moves; zero while nothing is
    under torque.
    """
    if C[EXPECTS_WEIGHT] == 0.0 or (G[AXIS_G + MODE] == 0 and G[AXIS_G + AXIS_G_SIZE + MODE] == 0):
        return 0.0, 0.0
    gravity = (H[BASE_GRAVITY], H[BASE_GRAVITY + 1], H[BASE_GRAVITY + 2])
    positions = H[AXIS_H + MEASURED_POSITION], H[_INNER + MEASURED_POSITION]
    outer, inner = gravity_torques(positions[0], positions[1], gravity, C, _MOMENTS[0], _MOMENTS[1])
    return -outer, -inner


@compiled
def _is_noisy(G: np.ndarray, g: int) -> bool:
    return bool(G[g + GYRO_QUIET_TICKS] >= _QUIET_LEAST and 2 * G[g + GYRO_QUIET_CHANGES] >= G[g + GYRO_QUIET_TICKS])
