"""Screening: what each family could explain of the residual near its starts, and what its negative control could.

The response of the twin to a family's probes is put beside the residual after everything that is already in the
hypothesis has been projected out of both. Nonsense of the same kind is the same response with its phase or its signs
scrambled: it has the same size and shape, and cannot be the cause.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.discrepancy.hypotheses import (
    Cause,
    Family,
    Fit,
    Hypothesis,
    Weighing,
    bounds_of,
    placed,
    prior_weights,
    shares_of,
    with_shares,
)
from gimbal_hil.knowledge.discrepancy.twin import TORQUE, Floats, Twin
from sim_backend.effects import Ripple, Start, ripple_start
from sim_backend.model import position_has_a_zero

#: a coordinate within this share of its range from an end is at its bound
_AT_BOUND = 1e-3
#: a response that is no larger, rms in what rows are weighed with, is rounding; a probe may be as small as a model's
#: number is, and the gap large
_ROUNDING = 1e-10
_ORDERS_TRIED = 3
_MOST_ORDERS = 4000
#: positions are put into cells of so many radians of the highest order's ripple
_CELL = 0.1
#: orders of a turning axis are tried no closer and no wider than this
_LEAST_STEP, _MOST_STEP = 0.02, 1.0
#: periods within the travel of a linear axis from which on a position effect is a ripple
_LEAST_PERIODS = 3.0
#: share of a scrambled response that may lie along the response itself, and how many are drawn for one that is kept
_RESEMBLES, _DRAWS_A_TRY = 0.25, 5


@dataclass(frozen=True)
class Proposal:
    """A family at a start: the share of squares that it would take, and where its coordinates would begin."""

    family: Family
    gain: float
    x: tuple[float, ...]


def basis_of(fit: Fit, weighing: Weighing) -> tuple[Floats, Floats]:
    """Orthonormal basis of what the hypothesis' coordinates can do (priors as extra rows), and the weighed residual
    with its prior rows.
    """
    weights, per_row = prior_weights(fit.hypothesis), row_weights(fit, weighing)
    residual = fit.residual.ravel() * per_row
    if not len(weights):
        return np.zeros((residual.size, 0)), residual
    pull = np.concatenate([np.zeros(len(weights) - len(fit.hypothesis.y)), np.array(fit.hypothesis.y)]) * weights
    # a coordinate at its bound can do no more
    low, high = bounds_of(fit.hypothesis, 1.0)
    x = fit.hypothesis.vector()
    margin = np.where(np.isfinite(high - low), _AT_BOUND * (high - low), 0.0)
    free = (x > low + margin) & (x < high - margin)
    basis, _ = np.linalg.qr(np.vstack([fit.jacobian * per_row[:, None], np.diag(weights)])[:, free])
    return basis, np.concatenate([residual, pull])


def row_weights(fit: Fit, weighing: Weighing) -> Floats:
    """What each element of a raveled residual is multiplied with."""
    return np.tile(1.0 / (np.array(weighing.scale) * weighing.spread), len(fit.residual))


@dataclass(frozen=True)
class Response:
    """What a family's start does to the residual: columns (rows * channels, probes), in floors times `floor`."""

    family: Family
    start: Start
    columns: Floats

    def over(self, ratio: Floats) -> Response:
        """The same over other floors: `ratio` is the floor of every channel over the new one."""
        return replace(self, columns=self.columns * np.tile(ratio, len(self.columns) // len(ratio))[:, None])


def respond(twin: Twin, fit: Fit, floor: Floats, family: Family) -> list[Response]:
    """Responses of one family at each of its starts; ripples at the orders that the residual suggests."""
    found = []
    for start in family.starts or ripple_starts(twin, fit, family):
        columns = responses(twin, fit.hypothesis, fit.residual, floor, family, start)
        if columns is not None:
            free = family.ripple and not position_has_a_zero(twin.model, family.axis)
            found.append(Response(family, start, _log_by_log(columns, twin) if free else columns))
    return found


def _log_by_log(columns: Floats, twin: Twin) -> Floats:
    """Probes of a ripple whose phase is another one in every log: those of the first log, then those of the others."""
    if len(twin.records) == 1:
        return columns
    ends = np.cumsum([int(record.keep.sum()) for record in twin.records]) * len(twin.channels)
    found = np.zeros((len(columns), columns.shape[1] * len(ends)))
    for which, (first, last) in enumerate(zip([0, *ends[:-1]], ends, strict=True)):
        found[first:last, which * columns.shape[1] : (which + 1) * columns.shape[1]] = columns[first:last]
    return found


def propose(fit: Fit, heard: list[Response], weighing: Weighing) -> list[Proposal]:
    """What each response could explain beside a fit, best first; gains are weighed squares."""
    basis, residual = basis_of(fit, weighing)
    per_row = row_weights(fit, weighing)
    residual = residual - basis @ (basis.T @ residual)
    found = []
    for response in heard:
        longer = beside(response.columns * per_row[:, None], basis)
        if np.linalg.norm(longer, axis=0).max() < _ROUNDING * np.sqrt(len(residual)):
            continue
        normal = longer.T @ longer
        coefficients = np.linalg.pinv(normal, rcond=1e-10, hermitian=True) @ (-longer.T @ residual)
        gain = float(-coefficients @ (longer.T @ residual))
        found.append(Proposal(response.family, gain, response.start.coordinates(coefficients)))
    return sorted(found, key=lambda p: -p.gain)


def beside(columns: Floats, basis: Floats) -> Floats:
    """What of responses is new beside what is there: rows as long as those of its `basis_of`, which go on with the
    priors of known numbers.
    """
    longer = np.zeros((len(basis), columns.shape[1]))
    longer[: len(columns)] = columns
    return np.asarray(longer - basis @ (basis.T @ longer))


def responses(
    twin: Twin, hypothesis: Hypothesis, residual: Floats, floor: Floats, family: Family, start: Start
) -> Floats | None:
    """Change of what a hypothesis leaves (in floors) per probe, (rows * channels, probes); None where a probe breaks
    the twin.
    """
    columns = []
    # in units of what comes through the hypothesis' own actuator: beside a limit that is tried too high every command
    # above it would count twenty times, so that no limit but the true one would seem to help
    shares = shares_of(twin, hypothesis, floor)
    for probe in start.probes:
        changed = with_shares(twin, hypothesis.plus(Cause(family, probe)), floor, shares)[0] - residual
        if not np.all(np.isfinite(changed)):
            return None
        columns.append(changed.ravel())
    return np.column_stack(columns)


def ripple_starts(twin: Twin, fit: Fit, family: Family) -> list[Start]:
    """The most promising orders of a ripple over position, read from the spectrum of the residual over position."""
    i = twin.model.axes.index(family.axis)
    channel = next(j for j, c in enumerate(twin.channels) if c.axis == family.axis and c.signal == TORQUE)
    records = placed(twin.records, fit.hypothesis)
    position = np.concatenate([r.at_scored(r.motion[:, i]) for r in records])
    rate = np.concatenate([r.at_scored(r.motion[:, 2 + i]) for r in records])
    y = fit.residual[:, channel]
    travel = max(float(np.ptp(position)), 1e-9)
    moving = np.abs(rate)[np.abs(rate) > 0.05 * np.abs(rate).max()]
    if not len(moving):
        return []
    step = 0.35 * np.pi / travel
    step = step if twin.model.is_linear else float(np.clip(step, _LEAST_STEP, _MOST_STEP))
    top = min(
        2.0 * np.pi * twin.records[0].bands.scored_hz / max(float(np.quantile(moving, 0.2)), 1e-9), _MOST_ORDERS * step
    )
    # along a straight way nothing repeats by itself: less than a few periods are no ripple
    least = _LEAST_PERIODS * 2.0 * np.pi / travel if twin.model.is_linear else 1.0
    orders = np.arange(least, max(top, 2.0 * least), step)
    weight = np.sign(rate) if family.ripple is Ripple.FRICTION else np.ones_like(rate)
    weight = weight * (np.abs(rate) > 0.002 * np.abs(rate).max()) if family.ripple is Ripple.FRICTION else weight
    base = np.column_stack([weight, np.ones_like(rate)])
    y = y - base @ np.linalg.lstsq(base, y, rcond=None)[0]
    free = not position_has_a_zero(twin.model, twin.model.axes[i])
    ends = [int(row) for row in np.cumsum([int(record.keep.sum()) for record in twin.records])[:-1]] if free else []
    logs = zip(np.split(y, ends), np.split(weight, ends), np.split(position, ends), strict=True)
    gains = np.sum([_ripple_gains(*log, orders) for log in logs], axis=0)
    chosen: list[float] = []
    for k in np.argsort(-gains):
        if all(abs(orders[k] - n) > 1.5 * np.pi / travel for n in chosen):
            chosen.append(float(orders[k]))
        if len(chosen) == _ORDERS_TRIED:
            break
    return [ripple_start(n) for n in chosen]


def _ripple_gains(y: Floats, weight: Floats, position: Floats, orders: Floats) -> Floats:
    """Squares that weight * (c cos n q + s sin n q) takes of y at evenly spaced orders n; sums over rows by a chirp-z
    transform.
    """
    from scipy.signal import czt

    step, cell = float(orders[1] - orders[0]), _CELL / float(orders[-1])
    at = np.round((position - position.min()) / cell).astype(int)

    def sums(values: Floats, harmonic: int) -> NDArray[np.complex128]:
        binned = np.bincount(at, values)
        turn = harmonic * cell
        return np.asarray(czt(binned, len(orders), np.exp(1j * turn * step), np.exp(-1j * turn * float(orders[0]))))

    both, twice, total = sums(weight * y, 1), sums(weight**2, 2), float(weight @ weight)
    cc, ss, cs = 0.5 * (total + twice.real), 0.5 * (total - twice.real), 0.5 * twice.imag
    determinant = cc * ss - cs**2
    full = (ss * both.real**2 - 2.0 * cs * both.real * both.imag + cc * both.imag**2) / np.maximum(determinant, 1e-300)
    return np.where(determinant > 1e-9 * cc * ss, full, both.real**2 / np.maximum(cc, 1e-12))


def control_gain(
    columns: Floats,
    residual: Floats,
    basis: Floats,
    rows: list[int],
    channels: int,
    block: int,
    seed: int,
    tries: int = 40,
) -> float:
    """Best gain of negative controls made of responses (rows * channels, k), beside a basis that the residual has
    nothing of.

    block 0: reversed and shifted in time within every record, which scrambles the phase of a ripple. Otherwise: sign
    drawn anew for every `block` rows, since a response that repeats with the laps would come back upon itself when
    shifted. A copy that still resembles the response is no control: a short log of slow motion has few blocks, and
    some draws leave most signs as they were. And what of a copy lies along the response takes what the cause takes.
    """
    rng = np.random.default_rng(seed)
    shaped = columns.reshape(sum(rows), channels, -1)
    own, _ = np.linalg.qr(beside(columns, basis))
    best, made = 0.0, 0
    for _ in range(_DRAWS_A_TRY * tries):
        parts, at = [], 0
        for n in rows:
            part = shaped[at : at + n]
            if block:
                part = part * np.repeat(rng.choice([-1.0, 1.0], n // block + 1), block)[:n, None, None]
            else:
                part = np.roll(
                    part[::-1] if rng.random() < 0.5 else part, int(rng.integers(n // 10, n - n // 10)), axis=0
                )
            parts.append(part)
            at += n
        scrambled = beside(np.concatenate(parts).reshape(columns.shape), basis)
        along = own.T @ scrambled
        if np.linalg.norm(along) ** 2 > _RESEMBLES * np.linalg.norm(scrambled) ** 2:
            continue
        scrambled -= own @ along
        coefficients = np.linalg.pinv(scrambled.T @ scrambled, rcond=1e-9, hermitian=True) @ (-scrambled.T @ residual)
        best, made = max(best, float(-coefficients @ (scrambled.T @ residual))), made + 1
        if made == tries:
            break
    return best
