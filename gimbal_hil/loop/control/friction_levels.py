"""Friction of the model at the motor's temperature, and its levels as the residual tells them.

A joint that slides lacks, beside what is fed forward, (a - 1) times the sliding part, (b - 1) times the viscous one,
and torque over position, of which an offset and a weight (sine and cosine of the position) are told apart.
All of them follow from means over a window of what the loops add, as a ridge regression. By how much each reversal
shifts an estimate tells its interval: a level goes from the model's only as far as its interval lies clear of that.
Torque that accelerates the joint and is fed forward late looks like viscosity, the more the faster the joint swings (on
a base that swings at 1 Hz by more than the whole of it): the interval of the viscous level holds that, too.
Levels stay within bounds, and change only while the joint slides: its bristles, as modelled, have bent in full, however
slow it is and however short the way.
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
    JERK,
    LARGEST_LEVEL,
    LAST_ACCELERATION,
    LATE_SUM,
    LEAST_LEVEL,
    LEVEL_BEFORE,
    LEVEL_ESTIMATE,
    LEVEL_REVERSALS,
    LEVEL_SHIFTS,
    LEVEL_SIDE,
    LEVEL_SUMS,
    LEVEL_WORK,
    MOVED_INERTIA,
    REGRESSORS,
    SHAPED_ACCELERATION,
    SHAPED_POSITION,
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

#: Stribeck velocities below which a joint rests, and the share of their steady deflection at which bristles slide
_RESTS, _SLIDES = 0.5, 0.98
#: torque over the sliding friction below which the model is believed more than the residual; less for the viscous part,
#: which a cold joint has several times
_RIDGE, _VISCOUS_RIDGE = 0.01, 0.0003
#: reversals after which shifts count (before, an estimate comes from nowhere), and after which intervals are believed
_BEGUN, _BELIEVED = 2.0, 4.0
#: half a 95 % interval, in standard errors
_CLEAR = 2.0
#: one standard deviation of how late the torque that accelerates may be fed forward (s)
_LATE_S = 0.005
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
    adapts = C[c + ADAPT_SHARE] > 0.0
    if adapts:
        H[h + VISCOUS_PART] = sigma2 * rate
        H[h + JERK] = (H[h + SHAPED_ACCELERATION] - H[h + LAST_ACCELERATION]) / step_s
        H[h + LAST_ACCELERATION] = H[h + SHAPED_ACCELERATION]
        level *= 1.0 + H[h + SLIDING_LEVEL]
        sigma2 *= 1.0 + H[h + VISCOUS_LEVEL]
    H[h + BRISTLE], torque = lugre_step(H[h + BRISTLE], rate, step_s, level, sigma0, sigma1, sigma2)
    if adapts:
        along = 1.0 if rate > 0.0 else -1.0
        held = along * level if sigma0 == 0.0 else sigma0 * H[h + BRISTLE]
        slides = abs(rate) > _RESTS * vs and along * held > _SLIDES * level
        H[h + SLIDING_PART] = held / (1.0 + H[h + SLIDING_LEVEL]) if slides else 0.0
    return float(torque)


@compiled
def adapt_friction(lacking_nm: float, H: np.ndarray, h: int, C: np.ndarray, c: int) -> None:
    """Take what the loops add to the torque that is fed forward (N m) into the levels of friction.

    Nothing is taken in while bristles bend, at the torque limit, and while the model is not trusted.
    """
    share, sliding = C[c + ADAPT_SHARE], H[h + SLIDING_PART]
    if share == 0.0 or sliding == 0.0 or H[h + DISTRUST] > 0.0 or abs(H[h + TORQUE]) >= C[c + TORQUE_LIMIT]:
        return
    sine, cosine = sine_cosine(H[h + SHAPED_POSITION])
    size = C[c + FRICTION_TC]
    told = H[h + VISCOUS_PART], sliding, size, size * sine, size * cosine
    # with what the levels give already
    beyond = lacking_nm + H[h + VISCOUS_LEVEL] * told[0] + H[h + SLIDING_LEVEL] * told[1]
    place = h + LEVEL_SUMS
    for i in range(REGRESSORS):
        for k in range(i, REGRESSORS):
            H[place] += share * (told[i] * told[k] - H[place])
            place += 1
        H[place] += share * (told[i] * beyond - H[place])
        place += 1
    H[h + LATE_SUM] += share * (H[h + MOVED_INERTIA] * H[h + JERK] * told[0] - H[h + LATE_SUM])
    _solve(h, size, H)
    _count_shifts(share, 1.0 if sliding > 0.0 else -1.0, h, H)
    _set_levels(h, C[c + LEAST_LEVEL] - 1.0, C[c + LARGEST_LEVEL] - 1.0, H)


@compiled
def _solve(h: int, friction_nm: float, H: np.ndarray) -> None:
    """Both estimates by the sums of an axis: elimination without pivots, which a matrix with a ridge needs none of. The
    two rows that are left stay in the room to solve it.
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
    for i in range(size - 1, 1, -1):
        for row in range(i):
            ratio = H[at + row * width + i] / H[at + i * width + i]
            for k in range(i):
                H[at + row * width + k] -= ratio * H[at + i * width + k]
            H[at + row * width + size] -= ratio * H[at + i * width + size]
    ratio = H[at + 1] / H[at + width + 1]
    viscous = (H[at + size] - ratio * H[at + width + size]) / (H[at] - ratio * H[at + width])
    H[h + LEVEL_ESTIMATE], H[h + LEVEL_ESTIMATE + 1] = viscous, _sliding_beside(viscous, h, H)


@compiled
def _sliding_beside(viscous: float, h: int, H: np.ndarray) -> float:
    """Sliding level beyond one that the sums ask for beside a viscous one."""
    row = h + LEVEL_WORK + REGRESSORS + 1
    return float((H[row + REGRESSORS] - H[row] * viscous) / H[row + 1])


@compiled
def _count_shifts(share: float, side: float, h: int, H: np.ndarray) -> None:
    """At a reversal, add the squares of the shifts since the one before; they fade as what was summed does. A steady
    estimate is a mean of swings, each of which shifts it by its weight: the sum of squares is its variance.
    """
    reversed_now = side * H[h + LEVEL_SIDE] < 0.0
    H[h + LEVEL_SIDE] = side
    for k in range(2):
        H[h + LEVEL_SHIFTS + k] *= (1.0 - share) ** 2
        if reversed_now:
            if H[h + LEVEL_REVERSALS] >= _BEGUN:
                H[h + LEVEL_SHIFTS + k] += (H[h + LEVEL_ESTIMATE + k] - H[h + LEVEL_BEFORE + k]) ** 2
            H[h + LEVEL_BEFORE + k] = H[h + LEVEL_ESTIMATE + k]
    if reversed_now:
        H[h + LEVEL_REVERSALS] += 1.0


@compiled
def _set_levels(h: int, low: float, high: float, H: np.ndarray) -> None:
    """Levels by the estimates, each within bounds and drawn to the model's by how far its interval reaches there."""
    if H[h + LEVEL_REVERSALS] < _BELIEVED:
        return
    late = _LATE_S * H[h + LATE_SUM] / H[h + LEVEL_SUMS] if H[h + LEVEL_SUMS] > 0.0 else 0.0
    viscous = clamp(_drawn_to_zero(H[h + LEVEL_ESTIMATE], H[h + LEVEL_SHIFTS] + late * late), low, high)
    sliding = _drawn_to_zero(H[h + LEVEL_ESTIMATE + 1], H[h + LEVEL_SHIFTS + 1])
    # beside a viscous level that was drawn back, sliding is no further from the model's than the sums ask for
    beside = _sliding_beside(viscous, h, H)
    if sliding * beside <= 0.0:
        sliding = 0.0
    elif abs(beside) < abs(sliding):
        sliding = beside
    H[h + VISCOUS_LEVEL], H[h + SLIDING_LEVEL] = viscous, clamp(sliding, low, high)


@compiled
def _drawn_to_zero(value: float, variance: float) -> float:
    """An estimate less what its interval makes doubtful of it: nothing where the interval holds zero."""
    square, doubtful = value * value, _CLEAR * _CLEAR * variance
    return value * (1.0 - doubtful / square) if square > doubtful else 0.0


@compiled
def has_new_levels(H: np.ndarray, h: int) -> bool:
    """Whether a level has changed by so much since it was last told; then it counts as told."""
    sliding, viscous = H[h + SLIDING_LEVEL], H[h + VISCOUS_LEVEL]
    if max(abs(sliding - H[h + TOLD_SLIDING]), abs(viscous - H[h + TOLD_VISCOUS])) < _WORTH_TELLING:
        return False
    H[h + TOLD_SLIDING], H[h + TOLD_VISCOUS] = sliding, viscous
    return True
