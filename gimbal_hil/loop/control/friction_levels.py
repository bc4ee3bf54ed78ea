"""Friction of the model at the motor's temperature, and its levels as the residual tells them.

A joint that slides lacks, beside what is fed forward, (a - 1) times the sliding part, (b - 1) times the viscous one,
and torque over position, of which an offset and a weight (sine and cosine of the position) are told apart.
All of them follow from means over a window of what the loops add, as a ridge regression: what the motion does not
excite stays as the model has it. Levels stay within bounds, and change only while the joint slides.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import exponential, sine_cosine
from gimbal_hil.loop.control.layout import (
    ADAPT_SHARE,
    BRISTLE,
    DISTRUST,
    FRICTION,
    FRICTION_ROW_SIZE,
    FRICTION_ROWS,
    FRICTION_TABLE,
    FRICTION_TC,
    FRICTION_VS,
    LARGEST_LEVEL,
    LEAST_LEVEL,
    LEVEL_SUMS,
    LEVEL_WORK,
    REGRESSORS,
    SHAPED_POSITION,
    SHAPED_RATE,
    SLIDING_LEVEL,
    SLIDING_PART,
    TOLD_SLIDING,
    TOLD_VISCOUS,
    TORQUE,
    TORQUE_LIMIT,
    VISCOSITY_FALL,
    VISCOUS_LEVEL,
    VISCOUS_PART,
)
from gimbal_hil.loop.control.pi import clamp
from sim_backend.friction import lugre_step, stribeck_level

#: Stribeck velocities beyond which a joint slides in full
_SLIDES = 5.0
#: torque over the sliding friction below which the model is believed more than the residual; less for the viscous part,
#: which a cold joint has several times
_RIDGE, _VISCOUS_RIDGE = 0.01, 0.003
#: the temperature at which a model's viscosity holds, as in `sim_backend.effects.temperature_viscosity`
_REFERENCE_DEGC = 20.0
#: change of a level that is told
_WORTH_TELLING = 0.05

Numbers = tuple[float, float, float, float, float, float, float]


@compiled
def friction_at(temperature_degc: float, C: np.ndarray, c: int) -> Numbers:
    """The model's friction numbers (in the order of the layout) at a temperature: between the rows of its table along
    straight lines, beyond them as the outermost row has it.
    """
    f, fall = c + FRICTION, C[c + VISCOSITY_FALL]
    rows = int(C[c + FRICTION_ROWS])
    ts, tc, vs, sigma0, sigma1, sigma2, delta = C[f], C[f + 1], C[f + 2], C[f + 3], C[f + 4], C[f + 5], C[f + 6]
    if rows > 0:
        above = 1
        while above < rows - 1 and C[c + FRICTION_TABLE + above * FRICTION_ROW_SIZE] < temperature_degc:
            above += 1
        a = c + FRICTION_TABLE + (above - 1) * FRICTION_ROW_SIZE
        b = c + FRICTION_TABLE + above * FRICTION_ROW_SIZE
        t = clamp((temperature_degc - C[a]) / (C[b] - C[a]), 0.0, 1.0)
        ts, tc = C[a + 1] + t * (C[b + 1] - C[a + 1]), C[a + 2] + t * (C[b + 2] - C[a + 2])
        vs, sigma0 = C[a + 3] + t * (C[b + 3] - C[a + 3]), C[a + 4] + t * (C[b + 4] - C[a + 4])
        sigma1, sigma2 = C[a + 5] + t * (C[b + 5] - C[a + 5]), C[a + 6] + t * (C[b + 6] - C[a + 6])
        delta = C[a + 7] + t * (C[b + 7] - C[a + 7])
    if fall != 0.0:
        sigma2 *= exponential(-fall * (temperature_degc - _REFERENCE_DEGC))
    return ts, tc, vs, sigma0, sigma1, sigma2, delta


@compiled
def modelled_friction(
    rate: float, temperature_degc: float, step_s: float, H: np.ndarray, h: int, C: np.ndarray, c: int
) -> float:
    """Torque (N m) that overcomes the model's friction at a wanted joint rate (rad/s) and a motor's temperature;
    bristles bend as they do in the joint.
    """
    ts, tc, vs, sigma0, sigma1, sigma2, delta = friction_at(temperature_degc, C, c)
    level = stribeck_level(abs(rate), ts, tc, vs, delta)
    if C[c + ADAPT_SHARE] > 0.0:
        H[h + SLIDING_PART] = level if rate > 0.0 else -level
        H[h + VISCOUS_PART] = sigma2 * rate
        level *= 1.0 + H[h + SLIDING_LEVEL]
        sigma2 *= 1.0 + H[h + VISCOUS_LEVEL]
    H[h + BRISTLE], torque = lugre_step(H[h + BRISTLE], rate, step_s, level, sigma0, sigma1, sigma2)
    return float(torque)


@compiled
def adapt_friction(lacking_nm: float, H: np.ndarray, h: int, C: np.ndarray, c: int) -> None:
    """Take what the loops add to the torque that is fed forward (N m) into the levels of friction.

    Nothing is taken in at rest, at the torque limit, and while the model is not trusted.
    """
    share = C[c + ADAPT_SHARE]
    rate = H[h + SHAPED_RATE]
    if share == 0.0 or H[h + DISTRUST] > 0.0 or abs(H[h + TORQUE]) >= C[c + TORQUE_LIMIT]:
        return
    if abs(rate) <= _SLIDES * C[c + FRICTION_VS]:
        return
    sine, cosine = sine_cosine(H[h + SHAPED_POSITION])
    size = C[c + FRICTION_TC]
    told = H[h + VISCOUS_PART], H[h + SLIDING_PART], size, size * sine, size * cosine
    # with what the levels give already
    beyond = lacking_nm + H[h + VISCOUS_LEVEL] * told[0] + H[h + SLIDING_LEVEL] * told[1]
    place = h + LEVEL_SUMS
    for i in range(REGRESSORS):
        for k in range(i, REGRESSORS):
            H[place] += share * (told[i] * told[k] - H[place])
            place += 1
        H[place] += share * (told[i] * beyond - H[place])
        place += 1
    low, high = C[c + LEAST_LEVEL] - 1.0, C[c + LARGEST_LEVEL] - 1.0
    H[h + VISCOUS_LEVEL], H[h + SLIDING_LEVEL] = _ridge_regression(h, size, low, high, H)


@compiled
def _ridge_regression(h: int, friction_nm: float, low: float, high: float, H: np.ndarray) -> tuple[float, float]:
    """First two coefficients by the sums of an axis, each within bounds, the second one for the first one as it is
    then: elimination without pivots, which a matrix with a ridge needs none of.
    """
    size, width, place = REGRESSORS, REGRESSORS + 1, h + LEVEL_SUMS
    at = h + LEVEL_WORK
    for i in range(size):
        for k in range(i, size):
            H[at + i * width + k] = H[at + k * width + i] = H[place]
            place += 1
        H[at + i * width + i] += ((_VISCOUS_RIDGE if i == 0 else _RIDGE) * friction_nm) ** 2
        H[at + i * width + size] = H[place]
        place += 1
    for i in range(size - 1, -1, -1):
        for row in range(i):
            ratio = H[at + row * width + i] / H[at + i * width + i]
            for k in range(i):
                H[at + row * width + k] -= ratio * H[at + i * width + k]
            H[at + row * width + size] -= ratio * H[at + i * width + size]
    first = clamp(H[at + size] / H[at], low, high)
    second = (H[at + width + size] - H[at + width] * first) / H[at + width + 1]
    return first, clamp(second, low, high)


@compiled
def has_new_levels(H: np.ndarray, h: int) -> bool:
    """Whether a level has changed by so much since it was last told; then it counts as told."""
    sliding, viscous = H[h + SLIDING_LEVEL], H[h + VISCOUS_LEVEL]
    if max(abs(sliding - H[h + TOLD_SLIDING]), abs(viscous - H[h + TOLD_VISCOUS])) < _WORTH_TELLING:
        return False
    H[h + TOLD_SLIDING], H[h + TOLD_VISCOUS] = sliding, viscous
    return True
