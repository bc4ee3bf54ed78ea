"""Torque over the joint's position: cogging, cable and drive offset by the model, and what no model has, learned.

The learned part is a table over a turn and both directions. While the joint moves, what the loops add to the torque
that is fed forward goes into the entries about where the joint is when it acts: iterative learning over position
(Arimoto et al. 1984), a share of it in each pass. Entries stay within a bound.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import sine_cosine
from gimbal_hil.loop.control.layout import (
    CABLE_REST,
    CABLE_STIFFNESS,
    DELAY_TICKS,
    DISTRUST,
    DRIVE_OFFSET,
    FASTEST_LEARNED,
    GIVEN_TABLE,
    LARGEST_LEARNED,
    LEARN_SHARE,
    LEARNED_BINS,
    LEARNED_TABLE,
    LEARNS,
    RIPPLE_COUNT,
    RIPPLE_SIZE,
    RIPPLES,
    SHAPED_POSITION,
    SHAPED_RATE,
    SLOWEST_LEARNED,
    TORQUE,
    TORQUE_LIMIT,
)
from gimbal_hil.loop.control.pi import clamp

_PER_RAD = LEARNED_BINS / (2.0 * math.pi)
#: bins on either side that learn from a residual. A triangle's spectrum has no negative part, so that every ripple
#: converges, the finer the slower
_REACH = 4


@compiled
def named_torque(position: float, C: np.ndarray, c: int) -> float:
    """Torque (N m) against the model's cogging, cable spring and drive offset at a joint position (rad)."""
    torque = C[c + CABLE_STIFFNESS] * (position - C[c + CABLE_REST]) - C[c + DRIVE_OFFSET]
    for k in range(int(C[c + RIPPLE_COUNT])):
        r = c + RIPPLES + k * RIPPLE_SIZE
        torque -= C[r] * sine_cosine(C[r + 1] * position + C[r + 2])[0]
    return float(torque)


@compiled
def bin_of(position: float) -> tuple[int, int, float]:
    """The bins (0 to LEARNED_BINS - 1) on both sides of a joint position (rad), and how far it is from the first one to
    the second (0 to 1).
    """
    place = position * _PER_RAD
    whole = math.floor(place)
    first = int(whole) % LEARNED_BINS
    return first, (first + 1) % LEARNED_BINS, place - whole


@compiled
def learned_torque(position: float, rate: float, H: np.ndarray, h: int, C: np.ndarray, c: int) -> float:
    """Torque (N m) of the table at a joint position (rad) and rate (rad/s); between the directions below the slowest
    rate that it learns at.
    """
    if C[c + LEARNS] == 0.0:
        return 0.0
    first, second, t = bin_of(position)
    forward = _forward_share(rate, C, c)
    torque = 0.0
    for side in range(2):
        weight = forward if side == 0 else 1.0 - forward
        a, b = side * LEARNED_BINS + first, side * LEARNED_BINS + second
        one = C[c + GIVEN_TABLE + a] + H[h + LEARNED_TABLE + a]
        other = C[c + GIVEN_TABLE + b] + H[h + LEARNED_TABLE + b]
        torque += weight * (one + t * (other - one))
    return float(torque)


@compiled
def learn(lacking_nm: float, step_s: float, H: np.ndarray, h: int, C: np.ndarray, c: int) -> None:
    """Take what the loops add to the torque that is fed forward (N m) into the table.

    Entries learn by what they gave. Nothing is learned at rest, beyond the fastest rate, at the torque limit, and while
    the model is not trusted.
    """
    share, rate = C[c + LEARN_SHARE], H[h + SHAPED_RATE]
    if share == 0.0 or H[h + DISTRUST] > 0.0 or abs(H[h + TORQUE]) >= C[c + TORQUE_LIMIT]:
        return
    if abs(rate) > C[c + FASTEST_LEARNED]:
        return
    # loops with an integrator add what is needed when it acts
    first, _, t = bin_of(H[h + SHAPED_POSITION] + C[c + DELAY_TICKS] * step_s * rate)
    # so much of a bin was passed in this tick: what a pass takes in does not depend on how fast it was
    taken = min(1.0, share * abs(rate) * step_s * _PER_RAD) * lacking_nm
    forward = _forward_share(rate, C, c)
    for side in range(2):
        of_side = taken * (forward if side == 0 else 1.0 - forward)
        if of_side != 0.0:
            for k in range(1 - _REACH, _REACH + 1):
                # a triangle about where the joint is: an edge of what was visited is no step
                weight = (1.0 - abs(k - t) / _REACH) / _REACH
                _add(weight * of_side, side * LEARNED_BINS + (first + k) % LEARNED_BINS, H, h, C, c)


@compiled
def _forward_share(rate: float, C: np.ndarray, c: int) -> float:
    """How much of the entries for the positive direction counts at a joint rate (rad/s)."""
    return 0.5 * (1.0 + clamp(rate / C[c + SLOWEST_LEARNED], -1.0, 1.0))


@compiled
def _add(torque: float, entry: int, H: np.ndarray, h: int, C: np.ndarray, c: int) -> None:
    given, most = C[c + GIVEN_TABLE + entry], C[c + LARGEST_LEARNED]
    H[h + LEARNED_TABLE + entry] = clamp(given + H[h + LEARNED_TABLE + entry] + torque, -most, most) - given
