"""Reversals of growing and shrinking size: a gap has a fixed width, bristles a stiffness; quick ones show inertia, lag
and delay.
"""

from __future__ import annotations

import numpy as np

from gimbal_hil.knowledge.experiments import Experiment
from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions
from gimbal_hil.knowledge.experiments.sequences.reference_motion import ROW_S, Floats, both_or_held, motion_experiment

#: size from the smallest to the largest and back (rad), at these frequencies (Hz), so long each
SMALLEST_RAD = 5e-4
LARGEST_RAD, FREQUENCIES_HZ = ((0.12, 0.04), (0.12, 0.04)), ((1.1, 3.7), (1.4, 3.2))
SWEEP_S, SHORT_SWEEP_S = 20.0, 12.0


def build(options: SequenceOptions) -> Experiment:
    """An amplitude sweep up and down at each frequency on the axes asked for."""
    duration_s = SHORT_SWEEP_S if options.short else SWEEP_S
    pair = zip(LARGEST_RAD, FREQUENCIES_HZ, strict=True)
    paths = dict(zip(options.names, (_swept(largest, hz, duration_s) for largest, hz in pair), strict=True))
    said = (
        "The size of the motion grows and shrinks at constant frequency; friction and gaps stay as they are, "
        "inertia grows with it."
    )
    return motion_experiment("reversals", "Reversals of many sizes", options, both_or_held(options, paths), said)


def _swept(largest: tuple[float, ...], frequencies_hz: tuple[float, ...], duration_s: float) -> Floats:
    t = np.arange(round(duration_s / ROW_S)) * ROW_S
    ends = np.clip(np.minimum(t, duration_s - t) / 0.5, 0.0, 1.0)
    parts = [np.zeros(round(0.5 / ROW_S))]
    for top, hz in zip(largest, frequencies_hz, strict=True):
        growing = 1.0 - np.abs(2.0 * t / duration_s - 1.0)
        parts.append(ends * SMALLEST_RAD * (top / SMALLEST_RAD) ** growing * np.sin(2.0 * np.pi * hz * t))
    return np.concatenate([*parts, np.zeros(round(0.5 / ROW_S))])
