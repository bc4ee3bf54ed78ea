"""Whether the antenna looks where it should: the mute signal, and what becomes of a direction without attitude.

A transmitter must be silent within 100 ms of looking more than 0.5 degrees past its satellite, and stay so until it
looks within 0.2 degrees of it (47 CFR 25.228 for terminals on aircraft). Muted is decided at every tick from the angle
between the direction asked for and where the encoders say that the antenna looks.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import sine_cosine
from gimbal_hil.loop.control import Mode
from gimbal_hil.loop.host.base_now import mean_rates
from gimbal_hil.loop.host.event_ring import report
from gimbal_hil.loop.host.layout import (
    ATTITUDE_AGE_S,
    ATTITUDE_TICKS,
    AXIS_H,
    AXIS_H_SIZE,
    AXIS_SEGMENT,
    BASE_AGE,
    BASE_ANGLES,
    BASE_NOW,
    BASE_RATES,
    CARRIED,
    CARRIED_ANGLES,
    CARRIED_JOINTS,
    CARRIED_RATES,
    COAST_TICKS,
    ERROR_TICKS,
    EXTRAPOLATES_BASE,
    FEEDBACK_AGE,
    LINK_STATUS,
    MEASURED_POSITION,
    MEASURED_RATE,
    MUTE_BELOW,
    MUTE_BEYOND,
    MUTE_TICKS,
    MUTED,
    POINTING_ERROR,
    POINTING_STATE,
    SEGMENT,
    SEGMENT_MODE,
    SEGMENT_RUNS,
    SEGMENT_SIZE,
    SKIPPED,
    STATE,
    STEP_S,
)
from gimbal_hil.loop.host.reception import NEVER
from gimbal_hil.loop.host.states import EventCode, HostState, LinkStatus, PointingState, number

_POINTING_MODE, _ACTIVE, _OK = number(Mode.POINTING), number(HostState.ACTIVE), number(LinkStatus.OK)
_EVENT = number(EventCode.POINTING)
_OFF, _ACQUIRING = number(PointingState.OFF), number(PointingState.ACQUIRING)
_TRACKING, _COASTING = number(PointingState.TRACKING), number(PointingState.COASTING)
_NO, _YES = number(0), number(1)
#: attitude older than this is carried on (s), rates older than this are the gyros'
_MOST_AGE_S = 0.1
#: the base turns no faster than this while the gyros tell (rad/s); a sample that says more is a jump of the clock
_MOST_RATE = 5.0
#: share of a new sample in the rates that the gyros tell
_RATE_SHARE = 0.1
#: nearer than this cosine of the pitch to the vertical, heading and roll have no rates of their own
_LEAST_COSINE = 0.05


@compiled
def is_pointing(G: np.ndarray, plan: np.ndarray) -> bool:
    """Whether a direction in space is followed at this tick."""
    if G[STATE] != _ACTIVE or G[SEGMENT_RUNS] != 1:
        return False
    return int(plan[G[SEGMENT] * SEGMENT_SIZE + AXIS_SEGMENT + SEGMENT_MODE]) == _POINTING_MODE


@compiled
def has_coasted(G: np.ndarray, C: np.ndarray) -> bool:
    """Whether no attitude has been heard for longer than gyros may hold a direction; one that never had any is on
    a base that stands still.
    """
    return bool(NEVER > G[ATTITUDE_TICKS] > _MOST_AGE_S / C[STEP_S] + C[COAST_TICKS])


@compiled
def judge_pointing(H: np.ndarray, G: np.ndarray, C: np.ndarray, plan: np.ndarray) -> None:
    """Mute or unmute at this tick, and say so."""
    state, muted, error = _OFF, G[MUTED], H[POINTING_ERROR]
    if not is_pointing(G, plan):
        muted = _YES
    else:
        G[ERROR_TICKS] = 0 if G[LINK_STATUS] == _OK else G[ERROR_TICKS] + 1 + G[SKIPPED]
        # gyros alone leave one rate unknown: nobody knows where the antenna looks, however small the error seems
        unknown = H[CARRIED] > 0.0 and G[BASE_AGE] * C[STEP_S] > _MOST_AGE_S
        if G[ERROR_TICKS] > C[MUTE_TICKS] or error > C[MUTE_BEYOND] or unknown:
            muted = _YES
        elif G[ERROR_TICKS] == 0 and error < C[MUTE_BELOW] and H[CARRIED] == 0.0:
            muted = _NO
        state = _COASTING if H[CARRIED] > 0.0 else (_ACQUIRING if muted == _YES else _TRACKING)
    if muted != G[MUTED] or state != G[POINTING_STATE]:
        report(G, _EVENT, state, muted, int(math.floor(1e6 * error + 0.5)))
    G[MUTED], G[POINTING_STATE] = muted, state


@compiled
def carry_attitude(H: np.ndarray, G: np.ndarray, C: np.ndarray) -> None:
    """Attitude of this tick while none is heard: turned on with the navigation's rates, or with what gyros and encoders
    say of two of them; the third, about the antenna's level axis, counts as zero.
    """
    if G[ATTITUDE_TICKS] == NEVER or G[ATTITUDE_TICKS] * C[STEP_S] <= _MOST_AGE_S:
        H[CARRIED] = 0.0
        return
    told, inner = BASE_RATES, AXIS_H + AXIS_H_SIZE
    if C[EXTRAPOLATES_BASE] > 0.0:
        told = BASE_NOW
    if H[CARRIED] == 0.0:
        H[CARRIED] = 1.0
        age = _MOST_AGE_S
        p, q, r = H[told], H[told + 1], H[told + 2]
        if C[EXTRAPOLATES_BASE] > 0.0:
            age = min(H[ATTITUDE_AGE_S], _MOST_AGE_S)
            p, q, r = mean_rates(H, age)
        for k in range(3):
            H[CARRIED_ANGLES + k], H[CARRIED_RATES + k] = H[BASE_ANGLES + k], H[told + k]
        _turn(H, p, q, r, age)
    elif G[BASE_AGE] * C[STEP_S] <= _MOST_AGE_S:
        for k in range(3):
            H[CARRIED_RATES + k] = H[told + k]
        _turn(H, H[told], H[told + 1], H[told + 2], C[STEP_S] * (1 + G[SKIPPED]))
    elif G[FEEDBACK_AGE] == 0:
        time_s = C[STEP_S] * (1 + G[SKIPPED])
        up = H[AXIS_H + MEASURED_RATE] - (H[AXIS_H + MEASURED_POSITION] - H[CARRIED_JOINTS]) / time_s
        across = H[inner + MEASURED_RATE] - (H[inner + MEASURED_POSITION] - H[CARRIED_JOINTS + 1]) / time_s
        if abs(up) < _MOST_RATE and abs(across) < _MOST_RATE:
            s, c = sine_cosine(H[AXIS_H + MEASURED_POSITION])
            p, q, r = -s * across, c * across, up
            _turn(H, p, q, r, time_s)
            H[CARRIED_RATES] += _RATE_SHARE * (p - H[CARRIED_RATES])
            H[CARRIED_RATES + 1] += _RATE_SHARE * (q - H[CARRIED_RATES + 1])
            H[CARRIED_RATES + 2] += _RATE_SHARE * (r - H[CARRIED_RATES + 2])
    H[CARRIED_JOINTS], H[CARRIED_JOINTS + 1] = H[AXIS_H + MEASURED_POSITION], H[inner + MEASURED_POSITION]


@compiled
def _turn(H: np.ndarray, p: float, q: float, r: float, time_s: float) -> None:
    """The carried attitude after a turn at p, q, r (rad/s) for so long (s)."""
    (sr, cr), (sp, cp) = sine_cosine(H[CARRIED_ANGLES]), sine_cosine(H[CARRIED_ANGLES + 1])
    cp = math.copysign(max(abs(cp), _LEAST_COSINE), cp)
    turn = (q * sr + r * cr) / cp
    H[CARRIED_ANGLES] += time_s * (p + sp * turn)
    H[CARRIED_ANGLES + 1] += time_s * (q * cr - r * sr)
    H[CARRIED_ANGLES + 2] += time_s * turn
