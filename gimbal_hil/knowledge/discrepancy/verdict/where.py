"""Where the gap sits: its share by axis, speed, position, direction, reversals, base motion, time and temperature."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.discrepancy.inquiry import BLOCK_S, DRAWS
from gimbal_hil.knowledge.discrepancy.twin import Channel, Floats, Record, Twin


class RegimeGroup(Enum):
    """Regimes that part the data by the same thing."""

    SPEED = "speed"
    DIRECTION = "direction"
    EFFORT = "effort"
    REVERSAL = "reversal"
    POSITION = "position"
    BASE = "base"
    TIME = "time"
    TEMPERATURE = "temperature"


@dataclass(frozen=True)
class Regime:
    """A part of the data: the share of a channel's gap that sits in it, with an interval, and the share of time that it
    is.
    """

    axis: str
    signal: str
    regime: str
    group: RegimeGroup
    share_of_gap: float
    low: float
    high: float
    share_of_time: float


def regimes(twin: Twin, residual: Floats, channel: Channel, column: int, seed: int = 1) -> list[Regime]:
    """Shares of one channel's squared residual by regime; block bootstrap for the intervals."""
    square = residual[:, column] ** 2
    total = float(square.sum())
    if total <= 0.0:
        return []
    block = np.concatenate([np.full(int(r.keep.sum()), 0.0) for r in twin.records])
    at = 0
    for k, record in enumerate(twin.records):
        n = int(record.keep.sum())
        block[at : at + n] = 100000 * k + np.floor(record.time_s[record.keep] / BLOCK_S)
        at += n
    _, number = np.unique(block, return_inverse=True)
    per_block = np.bincount(number, square)
    rng = np.random.default_rng(seed)
    draws = rng.integers(0, len(per_block), (DRAWS, len(per_block)))
    totals = per_block[draws].sum(axis=1)
    found = []
    for group, text, mask in _masks(twin, channel.axis):
        if not 0.02 < float(mask.mean()) < 0.98:
            continue
        inside = np.bincount(number, square * mask, minlength=len(per_block))
        shares = inside[draws].sum(axis=1) / np.maximum(totals, 1e-30)
        low, high = np.quantile(shares, [0.05, 0.95])
        share = float((square * mask).sum() / total)
        found.append(
            Regime(channel.axis, channel.signal, text, group, share, float(low), float(high), float(mask.mean()))
        )
    return found


def _masks(twin: Twin, axis: str) -> list[tuple[RegimeGroup, str, NDArray[np.bool_]]]:
    i = twin.model.axes.index(axis)
    unit = "m" if twin.model.is_linear else "rad"

    def column(values: list[Floats]) -> Floats:
        return np.concatenate([r.at_scored(v) for r, v in zip(twin.records, values, strict=True)])

    q = column([r.motion[:, i] for r in twin.records])
    v = column([r.motion[:, 2 + i] for r in twin.records])
    a = column([r.motion[:, 4 + i] for r in twin.records])
    speed = np.abs(v)
    slow, fast = 0.02 * float(speed.max()), float(np.quantile(speed, 0.7))
    out = [
        (RegimeGroup.SPEED, f"rate < {slow:.2g} {unit}/s", speed < slow),
        (RegimeGroup.SPEED, f"rate {slow:.2g}..{fast:.2g} {unit}/s", (speed >= slow) & (speed < fast)),
        (RegimeGroup.SPEED, f"rate > {fast:.2g} {unit}/s", speed >= fast),
        (RegimeGroup.DIRECTION, "moving forwards", v > slow),
        (RegimeGroup.DIRECTION, "moving backwards", v < -slow),
        (RegimeGroup.EFFORT, "speeding up", (v * a > 0.0) & (speed > slow)),
        (RegimeGroup.EFFORT, "slowing down", (v * a < 0.0) & (speed > slow)),
        (
            RegimeGroup.REVERSAL,
            "within 0.1 s of a reversal",
            column([_near_reversal(r, i) for r in twin.records]) > 0.5,
        ),
    ]
    edges = np.quantile(q, [0.0, 1 / 3, 2 / 3, 1.0])
    for low, high in pairwise(edges):
        out.append((RegimeGroup.POSITION, f"position {low:.2f}..{high:.2f} {unit}", (q >= low) & (q < high)))
    if any(r.moving_base for r in twin.records):
        rate = column([np.linalg.norm(r.base[:, 3:6], axis=1) for r in twin.records])
        out.append((RegimeGroup.BASE, "base rate above its median", rate > np.median(rate)))
    time = np.concatenate([r.time_s[r.keep] / r.time_s[-1] for r in twin.records])
    out.append((RegimeGroup.TIME, "second half of the logs", time > 0.5))
    if any(r.has_temperature for r in twin.records):
        heat = column([r.heat[:, i] for r in twin.records])
        out.append((RegimeGroup.TEMPERATURE, f"warmer than {np.median(heat):.1f} degC", heat > np.median(heat)))
    return out


def _near_reversal(record: Record, i: int) -> Floats:
    v = record.motion[:, 2 + i]
    crossing = np.zeros(len(v))
    crossing[1:] = np.sign(v[1:]) != np.sign(v[:-1])
    width = max(1, int(0.2 / record.bands.period_s))
    return np.asarray((np.convolve(crossing, np.ones(width), mode="same") > 0.5).astype(float))


def most_telling(found: list[Regime], count: int = 4) -> list[Regime]:
    """The regimes whose share of the gap stands furthest above their share of time, one per group."""
    best: dict[RegimeGroup, Regime] = {}
    for regime in sorted(found, key=lambda r: -(r.share_of_gap - r.share_of_time)):
        if regime.low > regime.share_of_time:
            best.setdefault(regime.group, regime)
    # a gap that is everywhere alike still has a place: the regime that holds most of it
    return list(best.values())[:count] or sorted(found, key=lambda r: -r.share_of_gap)[:1]
