"""Whether a model still helps: what it feeds forward against the torque that the motion takes, and loops that shake.

With N the torque sent and M what is fed forward, both at each tick, the model is worse than none once N alone
is smaller than N with M taken off: mean(N M) < mean(M^2) / 2, which noise in N does not shift. Counted is only where
friction at rest cannot hide the difference: while the joint slides and its friction is in M, or where M is thrice what
friction can hold. An observer whose inertia or delay is far off makes the loops swing: then the torque's feedback part
changes from tick to tick by a share of the limit that noise never asks for, and by more than twice what the reference
asks for where it jumps, as at the zenith with each attitude that is told.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from gimbal_hil.loop.control.layout import (
    DISTRUST,
    DRAG,
    EST_DISTURBANCE,
    EXPLAINED,
    FADE_STEP,
    FORWARD,
    FRICTION_FORWARD,
    FRICTION_TS,
    FRICTION_VS,
    JUMP,
    JUMPING,
    LAST_FEEDBACK,
    LEAST_TOLD,
    MOST_DELAY_TICKS,
    MOST_SHAKING,
    MOVED_INERTIA,
    OBSERVED,
    PENDING,
    POSITION_INTEGRAL,
    RATE_INTEGRAL,
    SEEN,
    SHAKING,
    SHAKING_SHARE,
    SHAPED_ACCELERATION,
    SHAPED_RATE,
    STALE,
    TOLD,
    TORQUE,
    TORQUE_LIMIT,
    TORQUE_SCALE,
    UNOBSERVED,
    WATCH_SHARE,
)

#: nothing changed; what is fed forward is stale, or right again; the observer's loops shake
UNCHANGED, TURNED_STALE, TURNED_RIGHT, SHAKES = range(4)
#: share of the model's own size that it has to explain: below it is stale, above it is right again
_LEAST_SHARE, _RIGHT_SHARE = 0.5, 0.75
#: what is fed forward over the friction at rest (or that nobody feeds forward), which could hide that it is wrong
_HIDDEN = 3.0
#: in squares, what a jump of the reference may bring: loops answer it with its own size, and take that back in the
#: ticks of the delay
_ANSWERED = 4.0
#: evidence before a judgement, of a full window's
_LEAST_SEEN = 0.5


@compiled
def judge_model(observed: bool, bodies: bool, H: np.ndarray, h: int, C: np.ndarray, c: int) -> int:
    """Take this tick's torque into the judgement of one axis' model; answers what changed. With `bodies` FORWARD holds
    what accelerates the joint, too.
    """
    sent, told = H[h + TORQUE], H[h + FORWARD]
    # the first one of a motion has none before it
    if observed and H[h + JUMP] == H[h + JUMP]:
        H[h + JUMPING] += C[c + SHAKING_SHARE] * (H[h + JUMP] * H[h + JUMP] - H[h + JUMPING])
    if abs(sent) >= C[c + TORQUE_LIMIT]:
        return UNCHANGED
    if not bodies:
        # what accelerates the joint is not the model's then
        sent_beside = sent - H[h + MOVED_INERTIA] * H[h + SHAPED_ACCELERATION]
    else:
        sent_beside = sent
    slides = C[c + FRICTION_FORWARD] > 0.0 and abs(H[h + SHAPED_RATE]) > C[c + FRICTION_VS]
    if slides or abs(told) > _HIDDEN * C[c + FRICTION_TS]:
        share = C[c + WATCH_SHARE]
        H[h + EXPLAINED] += share * (sent_beside * told - H[h + EXPLAINED])
        H[h + TOLD] += share * (told * told - H[h + TOLD])
        H[h + SEEN] += share * (1.0 - H[h + SEEN])
    if observed:
        feedback = sent - H[h + DRAG] - H[h + MOVED_INERTIA] * H[h + SHAPED_ACCELERATION]
        change = feedback - H[h + LAST_FEEDBACK]
        H[h + LAST_FEEDBACK] = feedback
        if change == change:
            H[h + SHAKING] += C[c + SHAKING_SHARE] * (change * change - H[h + SHAKING])
        if H[h + SHAKING] > C[c + MOST_SHAKING] + _ANSWERED * H[h + JUMPING]:
            return SHAKES
    if H[h + SEEN] < _LEAST_SEEN or H[h + TOLD] < C[c + LEAST_TOLD]:
        return UNCHANGED
    if H[h + STALE] == 0.0 and H[h + EXPLAINED] < _LEAST_SHARE * H[h + TOLD]:
        H[h + STALE] = 1.0
        return TURNED_STALE
    if H[h + STALE] > 0.0 and H[h + EXPLAINED] > _RIGHT_SHARE * H[h + TOLD]:
        H[h + STALE] = 0.0
        return TURNED_RIGHT
    return UNCHANGED


@compiled
def fade_model(observed: bool, drag: float, H: np.ndarray, h: int, C: np.ndarray, c: int) -> None:
    """One step of the model's share in the torque to where it is trusted; what goes from the feed-forward comes into
    the integrator or the estimated disturbance. `drag` is the part of FORWARD that accelerates nothing (N m).
    """
    before = H[h + DISTRUST]
    step = C[c + FADE_STEP]
    H[h + DISTRUST] = min(1.0, before + step) if H[h + STALE] > 0.0 else max(0.0, before - step)
    gone = H[h + DISTRUST] - before
    if gone == 0.0:
        return
    if observed:
        moved = gone * drag / H[h + MOVED_INERTIA]
        H[h + EST_DISTURBANCE] -= moved
        for k in range(MOST_DELAY_TICKS + 1):
            H[h + PENDING + k] += moved
    else:
        H[h + RATE_INTEGRAL] += gone * H[h + FORWARD] / C[c + TORQUE_SCALE]


@compiled
def leave_observer(H: np.ndarray, h: int, C: np.ndarray, c: int) -> None:
    """The cascade takes over from the observer, its integrator where the estimated disturbance is; for good."""
    limit = C[c + TORQUE_LIMIT]
    balance = -H[h + EST_DISTURBANCE] * H[h + MOVED_INERTIA]
    H[h + RATE_INTEGRAL] = min(max(balance, -limit), limit) / C[c + TORQUE_SCALE]
    H[h + POSITION_INTEGRAL] = 0.0
    H[h + UNOBSERVED] = 1.0


@compiled
def is_observed(H: np.ndarray, h: int, C: np.ndarray, c: int) -> bool:
    """Whether the observer closes the loops of an axis."""
    return bool(C[c + OBSERVED] > 0.0 and H[h + UNOBSERVED] == 0.0)
