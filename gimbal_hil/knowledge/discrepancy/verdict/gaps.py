"""How large each gap is, before and after, on rows of the hold-out that neither selected nor tuned anything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import noise_of_motion, torque_residual
from gimbal_hil.knowledge.discrepancy.inquiry import BLOCK_S, DRAWS, INTERVAL, LEAST_GAP, Inquiry, State
from gimbal_hil.knowledge.discrepancy.judgement import Result
from gimbal_hil.knowledge.discrepancy.twin import Floats

#: the gap over its floor below which a share means nothing
_A_GAP = 1.1
#: a floor is another than the one that was computed from this share of it down
_LOWER = 0.99


@dataclass(frozen=True)
class Gap:
    """One channel's gap, rms in its unit within the band."""

    axis: str
    signal: str
    unit: str
    band_hz: tuple[float, float]
    #: as the model file stands; with known numbers inside their uncertainty; with what is told
    before: float
    after_recalibration: float
    after: float
    #: of the model as it stands; and with what is told, where a larger inertia makes more of the encoder's error
    noise_floor: float
    noise_floor_after: float
    noise_floor_from: str
    processing_floor: float
    closed_fraction: float | None
    closed_low: float | None
    closed_high: float | None
    #: 90 % block-bootstrap interval of `before`
    before_low: float
    before_high: float
    on: str = "held-out"


def largest(gaps: Sequence[Gap]) -> Gap:
    """The one with most noise floors before anything is told."""
    return max(gaps, key=lambda gap: gap.before / gap.noise_floor)


def still_open(gaps: Sequence[Gap]) -> list[Gap]:
    """Those that what is told leaves above the limit, the largest first; in floors of the model with it."""
    left = [gap for gap in gaps if gap.after > LEAST_GAP * gap.noise_floor_after]
    return sorted(left, key=lambda gap: -gap.after / gap.noise_floor_after)


def share_text(share: float) -> str:
    """A closed share in percent: what is not all of it is not said to be 100%."""
    said = f"{share:.0%}"
    if share >= 1.0 or said != "100%":
        return said
    said = f"{share:.1%}"
    return "over 99.9%" if said == "100.0%" else said


def closed_most(gaps: Sequence[Gap]) -> Gap:
    """The one that what is told closes most noise floors of."""
    return max(gaps, key=lambda gap: (gap.after_recalibration - gap.after) / gap.noise_floor)


def gaps_of(result: Result) -> tuple[Gap, ...]:
    """One gap per channel."""
    inquiry, bands = result.inquiry, result.inquiry.twin.records[0].bands

    def rows(state: State, under: Inquiry = inquiry) -> Floats:
        return torque_residual(under.holdout, state.hypothesis, inquiry.floor)[~inquiry.selecting]

    stated, null, best = rows(result.stated), rows(result.null), rows(result.best, result.under)
    length = max(2, int(BLOCK_S / (bands.stride * bands.period_s)))
    noise_after = inquiry.floor * noise_of_motion(inquiry.twin, result.best.hypothesis, inquiry.from_encoder)
    found = []
    for j, channel in enumerate(inquiry.twin.channels):
        floor, noise = float(inquiry.floor[j]), result.noise.floors[j]
        before, moved, after = (float(np.sqrt(np.mean(part[:, j] ** 2))) * floor for part in (stated, null, best))
        closed = low = high = None
        least, most = (floor * end for end in _rms_within(stated[:, j] ** 2, length))
        if moved > _A_GAP * floor:
            closed, low, high = _closed(null[:, j] ** 2, best[:, j] ** 2, length)
        unit = channel.unit(result.model.is_linear)
        source = (
            "what a regression with free numbers, or an explanation, leaves of the hold-out"
            if noise.rms < _LOWER * min(noise.from_spectrum, noise.from_repeats or np.inf)
            else "repeats"
            if noise.from_repeats is not None and noise.rms == noise.from_repeats
            else "spectrum above the band"
        )
        found.append(Gap(
            channel.axis, channel.signal, unit, (0.0, bands.scored_hz), before, moved, after, floor,
            float(noise_after[j]), source, float(result.noise.processing[j]), closed, low, high,
            least, most,
        ))  # fmt: skip
    return tuple(found)


def _closed(before: Floats, after: Floats, length: int) -> tuple[float, float, float]:
    """Closed share of the gap and its 90 % block-bootstrap interval; squares in floors."""

    def share(x: Floats, y: Floats) -> Floats:
        return np.asarray(1.0 - (y - 1.0) / np.maximum(x - 1.0, 1e-9))

    low, high = np.quantile(share(*_drawn_again((before, after), length)), INTERVAL)
    whole = float(share(np.asarray(before.mean()), np.asarray(after.mean())))
    return min(1.0, whole), min(1.0, float(low)), min(1.0, float(high))


def _rms_within(squares: Floats, length: int) -> tuple[float, float]:
    """90 % block-bootstrap interval of the rms of what is left, the rms of all rows in it; squares in floors."""
    (drawn,), whole = _drawn_again((squares,), length), float(squares.mean())
    low, high = np.quantile(drawn, INTERVAL)
    return float(np.sqrt(min(low, whole))), float(np.sqrt(max(high, whole)))


def _drawn_again(columns: Sequence[Floats], length: int) -> list[Floats]:
    """Means (draws,) of columns of one length (n,) each, their blocks drawn again, the same ones of each. No row is
    left over: a few of them may hold all of a gap.
    """
    rows = len(columns[0])
    blocks = max(rows // length, min(4, rows))
    draws = np.random.default_rng(2).integers(0, blocks, (DRAWS, blocks))
    means = (np.array([block.mean() for block in np.array_split(one, blocks)]) for one in columns)
    return [one[draws].mean(axis=1) for one in means]
