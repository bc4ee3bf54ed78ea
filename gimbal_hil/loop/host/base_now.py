"""The base as it is now: what the navigation told, extrapolated by its age.

The heading tells when the attitude was true; rates and acceleration of one navigation are taken to be as old when they
are sent. Angular acceleration and its change are differences of the last three rates.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from gimbal_hil.loop.control import gravity_in_base
from gimbal_hil.loop.host.layout import (
    ATTITUDE_AGE_S,
    BASE_ACCELERATION,
    BASE_AGE,
    BASE_ANGLES,
    BASE_FELT,
    BASE_HALFWAY,
    BASE_JERK,
    BASE_LOST_TICKS,
    BASE_NOW,
    BASE_RATES,
    BASE_TURNED,
    BASE_TURNING,
    EXTRAPOLATES_BASE,
    NAVIGATION_AGE_S,
    SKIPPED,
    STEP_S,
)

#: rates farther apart than so many ticks say nothing of the angular acceleration
_MOST_TICKS = 64
#: an attitude older than this is not extrapolated further (s)
_MOST_AGE_S = 0.1


@compiled
def learn_turning(mail: np.ndarray, H: np.ndarray, G: np.ndarray, C: np.ndarray) -> None:
    """Angular acceleration of the base and its change, when a base_rate has come and before it takes the last one's
    place. The last two rates tell the acceleration half-way between them, half a period ago: what it has changed by
    since is in the three.
    """
    ticks = G[BASE_AGE] + 1
    period_s, near = ticks * C[STEP_S], ticks <= _MOST_TICKS
    for k in range(3):
        before = H[BASE_HALFWAY + k]
        H[BASE_HALFWAY + k] = (mail[m.BASE_RATE_P + k] * m.BASE_RATE_P_STEP - H[BASE_RATES + k]) / period_s
        turned, jerk = H[BASE_HALFWAY + k], 0.0
        if not near:
            turned, H[BASE_HALFWAY + k] = 0.0, math.nan
        elif not math.isnan(before):
            jerk = (turned - before) / period_s
        H[BASE_TURNED + k], H[BASE_JERK + k] = turned + 0.5 * period_s * jerk, jerk


@compiled
def has_attitude(mail: np.ndarray, C: np.ndarray) -> bool:
    """Whether roll, pitch and heading of one instant are in the mail, and the device's tick where their age matters."""
    # roll and pitch stay in the mail until the heading of the same instant has come
    same = mail[m.BASE_ATTITUDE_SET] == mail[m.BASE_HEADING_VALID_TICK] & m.BASE_ATTITUDE_SET_HIGH
    return bool(mail[m.BASE_HEADING] > 0 and same and (C[EXTRAPOLATES_BASE] == 0.0 or mail[m.DRIVE_STATUS] > 0))


@compiled
def extrapolate_base(mail: np.ndarray, H: np.ndarray, G: np.ndarray, C: np.ndarray) -> None:
    """Rates, gravity and age of the attitude as of this tick, once its mail has been taken in."""
    if G[BASE_AGE] > C[BASE_LOST_TICKS]:
        for k in range(3):
            H[BASE_TURNED + k] = H[BASE_JERK + k] = 0.0
    H[ATTITUDE_AGE_S] += C[STEP_S] * (1 + G[SKIPPED])
    if has_attitude(mail, C):
        ticks = (mail[m.DRIVE_STATUS_TICK] - mail[m.BASE_HEADING_VALID_TICK]) & m.BASE_HEADING_VALID_TICK_HIGH
        age = (ticks - mail[m.BASE_HEADING_VALID_FRACTION] * m.BASE_HEADING_VALID_FRACTION_STEP) * C[STEP_S]
        if age < _MOST_AGE_S:
            # the heading is sent one tick after the attitude
            H[ATTITUDE_AGE_S], H[NAVIGATION_AGE_S] = age, max(0.0, age - C[STEP_S])
    age = H[NAVIGATION_AGE_S] + G[BASE_AGE] * C[STEP_S] if G[BASE_AGE] <= _MOST_TICKS else 0.0
    for k in range(3):
        turned, change = H[BASE_TURNED + k], age * H[BASE_JERK + k]
        H[BASE_NOW + k] = H[BASE_RATES + k] + age * (turned + 0.5 * change)
        H[BASE_TURNING + k] = turned + change
    _felt_now(H)


@compiled
def _felt_now(H: np.ndarray) -> None:
    """Gravity turned on from the attitude with the rates since, less the pivot's acceleration as last told."""
    gx, gy, gz = gravity_in_base(H[BASE_ANGLES], H[BASE_ANGLES + 1])
    age = min(H[ATTITUDE_AGE_S], _MOST_AGE_S)
    p, q, r = mean_rates(H, age)
    H[BASE_FELT] = gx - age * (q * gz - r * gy) - H[BASE_ACCELERATION]
    H[BASE_FELT + 1] = gy - age * (r * gx - p * gz) - H[BASE_ACCELERATION + 1]
    H[BASE_FELT + 2] = gz - age * (p * gy - q * gx) - H[BASE_ACCELERATION + 2]


@compiled
def mean_rates(H: np.ndarray, age_s: float) -> tuple[float, float, float]:
    """Mean angular rate of the base (rad/s) over the last `age_s` seconds."""
    return _mean_rate(H, 0, age_s), _mean_rate(H, 1, age_s), _mean_rate(H, 2, age_s)


@compiled
def _mean_rate(H: np.ndarray, k: int, age_s: float) -> float:
    return float(H[BASE_NOW + k] - age_s * (0.5 * H[BASE_TURNING + k] - age_s * H[BASE_JERK + k] / 6.0))
