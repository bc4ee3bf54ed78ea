"""How well a model fits one log, without a search: the residual of each channel beside its noise floor."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.hypotheses import Hypothesis, torque_residual
from gimbal_hil.knowledge.discrepancy.inquiry.prepare import judged_alone
from sim_backend.model import AntennaModel


class StandingGap(TypedDict):
    """One entry of `gaps` in verdict.json, where nothing was searched: the keys of shares and intervals are null."""

    axis: str
    signal: str
    unit: str
    band_hz: list[float]
    before: float
    after: float
    noise_floor: float
    noise_floor_after: float
    noise_floor_from: str
    processing_floor: float
    closed_fraction: None
    closed_low: None
    closed_high: None
    before_low: None
    before_high: None
    on: str


def standing(model: AntennaModel, table: SignalsTable) -> list[StandingGap]:
    """One gap per channel in the form of a verdict's `gaps`, before and after being the same: nothing is searched for
    or tuned.
    """
    twin, noise = judged_alone(model, table)
    floor, hz = noise.effective(twin), twin.records[0].bands.scored_hz
    rms = np.sqrt(np.mean(torque_residual(twin, Hypothesis(), floor) ** 2, axis=0)) * floor
    return [
        {
            "axis": channel.axis,
            "signal": channel.signal,
            "unit": channel.unit(model.is_linear),
            "band_hz": [0.0, hz],
            "before": float(rms[j]),
            "after": float(rms[j]),
            "noise_floor": float(floor[j]),
            "noise_floor_after": float(floor[j]),
            "noise_floor_from": "this log",
            "processing_floor": float(noise.processing[j]),
            "closed_fraction": None,
            "closed_low": None,
            "closed_high": None,
            "before_low": None,
            "before_high": None,
            "on": "a motion that the model has not seen",
        }
        for j, channel in enumerate(twin.channels)
    ]
