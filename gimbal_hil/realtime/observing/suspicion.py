"""What seems to be growing on an axis, while it runs: a name for the change of what the model lacks.

The last seconds of motion are compared with the minute before. What they lack beyond it is put beside the traces of a
few causes; one is suspected where it takes nearly all of that, and no other would, with the probability that squares
and counted numbers give it. Slow drifts move the minute before along and are no onset.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
#: rows during which gyro and encoder come apart, and the largest angle, rad
Slip = tuple[NDArray[np.bool_], float]

#: rows of the means that are looked at, s; how long ago the last of the minute before, seconds of it, and of now
_ROW_S, _GAP_S, _BEFORE_S, _NOW_S = 0.02, 4.0, 60.0, 4.0
_MOST_ROWS = round((_BEFORE_S + _GAP_S + _NOW_S) / _ROW_S)
#: motion that is needed of either, s, and how often it is looked at
_LEAST_BEFORE_S, _LEAST_NOW_S, _EVERY_S = 10.0, 2.0, 0.5
#: slower than this an axis does not surely slide, rad/s
_SLIDES_RAD_S = 5e-3
#: what is lacked now over what was before, beyond its own regression, from which it is an onset
_ONSET = 3.0
#: of that a cause must take this share of the squares, at this probability, this many times in a row
_TAKES, _SURE, _IN_A_ROW = 0.8, 0.95, 4
#: rows that count as one; numbers of something else that would take everything
_CORRELATED, _NUMBERS_ELSE = 5.0, 8
#: nothing is followed more exactly than to this share of the squares
_EXACT = 0.01
#: orders of a ripple per turn
_ORDERS = np.arange(3, 73)
#: a slip: an angle that gyro and encoder differ by within this time, over what they usually do, and at least, rad
_SLIP_S, _SLIP, _LEAST_SLIP_RAD = 0.4, 8.0, 1e-3
#: share of the time that slips may take with what the observer makes of them
_EVENTS = 0.7
#: share of what is missing during slips that may not be taken back
_NET = 0.35
_RIDGE = 1e-6
#: parts of the minute before that are left out one after another
_PARTS = 8


class Growing(StrEnum):
    """What may be suspected of an axis."""

    RIPPLE = "ripple"
    FRICTION = "friction level"
    ENCODER = "slipping encoder"
    GAIN = "torque gain"
    UNBALANCE = "unbalance"


#: the experiment that confirms each
CONFIRMED_BY: Mapping[Growing, str] = {
    Growing.RIPPLE: "full_turn",
    Growing.FRICTION: "plateaus",
    Growing.ENCODER: "full_turn",
    Growing.GAIN: "two_loads",
    Growing.UNBALANCE: "full_turn",
}


@dataclass(frozen=True)
class Suspected:
    """A cause with its probability, and its size in N m (of a gain a share, of an encoder rad); a ripple's order."""

    cause: Growing
    probability: float
    size: float
    order: int = 0

    @property
    def text(self) -> str:
        """In words."""
        unit = {Growing.GAIN: "", Growing.ENCODER: " rad"}.get(self.cause, " N m")
        what = f"{self.cause.value} of order {self.order}" if self.cause is Growing.RIPPLE else self.cause.value
        return f"{what}, {self.size:.2g}{unit}, probability {self.probability:.2f}"


@dataclass
class SuspicionWatch:
    """One axis: fed tick by tick, looked at twice a second."""

    rate_hz: float
    least_nm: float
    #: by how much what is told of the missing torque is late
    delay_s: float = 0.0
    suspected: Suspected | None = None
    _rows: deque[tuple[float, ...]] = field(default_factory=lambda: deque(maxlen=_MOST_ROWS))
    _sums: list[float] = field(default_factory=lambda: [0.0] * 4)
    _ticks: int = 0
    _since: int = 0
    _at_rad: float | None = None
    _in_a_row: tuple[Growing | None, int] = (None, 0)

    def take(self, missing_nm: float, position_rad: float, torque_nm: float, gyro_error_rad_s: float) -> bool:
        """One tick; answers whether what is suspected has just changed."""
        sums = self._sums
        sums[0] += missing_nm
        sums[1] += position_rad
        sums[2] += torque_nm
        sums[3] += gyro_error_rad_s
        self._ticks += 1
        if self._ticks < _ROW_S * self.rate_hz:
            return False
        missing, position, torque, gyro = (value / self._ticks for value in sums)
        before, self._at_rad = self._at_rad, position
        self._sums, self._ticks = [0.0] * 4, 0
        if before is None:
            return False
        # the rate of the joint itself, whatever the base does
        self._rows.append((missing, position, (position - before) / _ROW_S, torque, gyro))
        self._since += 1
        if self._since * _ROW_S < _EVERY_S:
            return False
        self._since = 0
        return self._look()

    def forget(self) -> None:
        """Motion that is interrupted begins anew."""
        self._sums, self._ticks, self._at_rad = [0.0] * 4, 0, None

    def learn_anew(self) -> None:
        """What was before counts no more."""
        self._rows.clear()
        self.suspected, self._in_a_row = None, (None, 0)

    def _look(self) -> bool:
        found = suspicion(_together(np.array(self._rows), round(self.delay_s / _ROW_S)), self.least_nm)
        cause = None if found is None else found.cause
        self._in_a_row = (cause, self._in_a_row[1] + 1 if cause is self._in_a_row[0] else 1)
        before = None if self.suspected is None else self.suspected.cause
        if found is None or self._in_a_row[1] < _IN_A_ROW:
            # what was told stays told until another cause is sure, or people say that it is usual now
            return False
        self.suspected = found
        return found.cause is not before


def _together(rows: Floats, late: int) -> Floats:
    """Rows with each missing torque beside the motion that it was of."""
    if late == 0 or len(rows) <= late:
        return rows
    return np.column_stack([rows[late:, 0], rows[:-late, 1:4], rows[late:, 4]])


def suspicion(rows: Floats, least_nm: float) -> Suspected | None:
    """What seems to grow at the end of rows (missing torque, position, rate, torque, gyro error), (n, 5), one every
    20 ms.
    """
    now, gap = round(_NOW_S / _ROW_S), round(_GAP_S / _ROW_S)
    if len(rows) < now + gap + _LEAST_BEFORE_S / _ROW_S:
        return None
    before, after = rows[: -now - gap], rows[-now:]
    slipped = _slip(before[:, 4], after[:, 4])
    before = before[np.abs(before[:, 2]) > _SLIDES_RAD_S]
    slides = (np.abs(after[:, 2]) > _SLIDES_RAD_S) & _been_at(before[:, 1], after[:, 1])
    if len(before) < _LEAST_BEFORE_S / _ROW_S or np.sum(slides) < _LEAST_NOW_S / _ROW_S:
        return None
    numbers, spread, noise = _usual(before)
    expected = _regressors(after)
    left = (after[:, 0] - expected @ numbers)[slides]
    # other motion than before asks more of the numbers than they were seen to hold
    unsure = float(np.mean(np.einsum("ni,ij,nj->n", expected[slides], spread, expected[slides])))
    noise = max(math.sqrt(noise**2 + unsure), least_nm / _ONSET)
    if float(np.sqrt(np.mean(left**2))) < _ONSET * noise:
        return None
    return _named(left, after[slides], noise, None if slipped is None else (slipped[0][slides], slipped[1]))


def _been_at(before: Floats, now: Floats) -> NDArray[np.bool_]:
    """Which positions of now the minute before has been at: what is missing elsewhere may have been there all along."""
    low, high = float(np.min(before, initial=np.inf)), float(np.max(before, initial=-np.inf))
    return ((now >= low) & (now <= high)) | (high - low >= 2.0 * math.pi)


def _usual(before: Floats) -> tuple[Floats, Floats, float]:
    """What the minute before lacked in usual motion: numbers (6,) with their covariance (6, 6) by leaving out one part
    of the minute after another, since what is left goes on for seconds, and the standard deviation of what is left.
    """
    regressors = _regressors(before)
    ridge = _RIDGE * len(before) * np.eye(regressors.shape[1])
    parts = np.array_split(np.arange(len(before)), _PARTS)
    grams = np.array([regressors[part].T @ regressors[part] for part in parts])
    moments = np.array([regressors[part].T @ before[part, 0] for part in parts])
    numbers = np.linalg.solve(grams.sum(axis=0) + ridge, moments.sum(axis=0))
    without = np.linalg.solve(grams.sum(axis=0) - grams + ridge, (moments.sum(axis=0) - moments)[:, :, None])[:, :, 0]
    apart = without - without.mean(axis=0)
    covariance = (_PARTS - 1) / _PARTS * apart.T @ apart
    return numbers, covariance, float(np.std(before[:, 0] - regressors @ numbers))


def _regressors(rows: Floats) -> Floats:
    """What usual motion may lack anyway: level, friction, viscosity, gain, unbalance."""
    _, q, v, u, _ = rows.T
    return np.column_stack([np.ones(len(q)), np.sign(v), v, u, np.cos(q), np.sin(q)])


def _named(
    left: Floats, rows: Floats, noise: float, slipped: tuple[NDArray[np.bool_], float] | None
) -> Suspected | None:
    """The cause that takes nearly all of what is left, if one does."""
    _, q, v, u, _ = rows.T
    order, ripple = _ripple(left, q)
    sides = np.column_stack([np.cos(q), np.sin(q)])
    tried: list[tuple[Growing, Floats, int]] = [
        (Growing.FRICTION, np.sign(v)[:, None], 1),
        (Growing.GAIN, u[:, None], 1),
        (Growing.UNBALANCE, sides, 2),
        (Growing.RIPPLE, ripple, 3),
    ]
    count, whole = len(left) / _CORRELATED, float(np.mean(left**2))

    def weight(squares: float, numbers: int) -> float:
        return -0.5 * count * math.log(max(squares / whole, noise**2 / whole, _EXACT)) - 0.5 * numbers * math.log(count)

    found: list[tuple[float, float, Suspected]] = []
    for cause, columns, numbers in tried:
        scales = np.linalg.lstsq(columns, left, rcond=None)[0]
        squares = float(np.mean((left - columns @ scales) ** 2))
        size = float(np.hypot(*scales)) if len(scales) == 2 else float(scales[0])
        one = Suspected(cause, 0.0, size, int(order) if cause is Growing.RIPPLE else 0)
        found.append((weight(squares, numbers), squares, one))
    if slipped is not None and _undone(left[slipped[0]]):
        during, angle = slipped
        squares = float(np.mean(np.where(during, noise**2, left**2)))
        events = 1 + int(np.sum(np.diff(during.astype(int)) > 0))
        found.append((weight(squares, 2 * events), squares, Suspected(Growing.ENCODER, 0.0, angle)))
    most, squares, best = max(found, key=lambda one: one[0])
    everything = [0.0, weight(0.0, _NUMBERS_ELSE), *(one[0] for one in found)]
    probability = 1.0 / sum(math.exp(min(one - most, 700.0)) for one in everything)
    if squares > (1.0 - _TAKES) * whole + noise**2 or probability < _SURE:
        return None
    return Suspected(best.cause, probability, best.size, best.order)


def _undone(left: Floats) -> bool:
    """Whether a missing torque is taken back at once: a step of the encoder moves nothing, whatever the observer makes
    of it meanwhile.
    """
    return bool(abs(np.sum(left)) < _NET * np.sum(np.abs(left)))


def _ripple(left: Floats, q: Floats) -> tuple[int, Floats]:
    """The order that takes most, and its two columns."""
    angles = np.outer(q, _ORDERS)
    cosine, sine = np.cos(angles), np.sin(angles)
    cc, ss, cs = np.sum(cosine**2, axis=0), np.sum(sine**2, axis=0), np.sum(cosine * sine, axis=0)
    c, s = left @ cosine, left @ sine
    determinant = np.maximum(cc * ss - cs**2, 1e-9 * len(left) ** 2)
    takes = (c * c * ss - 2.0 * c * s * cs + s * s * cc) / determinant
    best = int(np.argmax(takes))
    return int(_ORDERS[best]), np.column_stack([cosine[:, best], sine[:, best]])


def _slip(before: Floats, after: Floats) -> Slip | None:
    """Rows during which encoder and gyro came to differ by an angle, and the largest of these, rad."""
    width = round(_SLIP_S / _ROW_S)

    def jumps(rates: Floats) -> Floats:
        turned = np.concatenate([[0.0], np.cumsum(rates) * _ROW_S])
        return np.asarray(turned[width:] - turned[:-width])

    usual = jumps(before)
    middle, spread = float(np.median(usual)), float(np.median(np.abs(usual - np.median(usual)))) * 1.4826
    now = jumps(after) - middle
    beyond = np.abs(now) > max(_SLIP * spread, _LEAST_SLIP_RAD)
    if not np.any(beyond):
        return None
    during = np.convolve(beyond, np.ones(2 * width + 1), mode="full")[: len(after)] > 0.0
    # a slip is an event; what lasts is none
    if np.mean(during) > _EVENTS:
        return None
    return during, float(now[int(np.argmax(np.abs(now)))])


__all__ = ["CONFIRMED_BY", "Growing", "Suspected", "SuspicionWatch", "suspicion"]
