"""Constant speeds over a decade and a half in both directions: tells drags, asymmetries, gain and offset apart."""

from __future__ import annotations

import numpy as np

from gimbal_hil.knowledge.experiments import Experiment
from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions
from gimbal_hil.knowledge.experiments.sequences.reference_motion import (
    Floats,
    ReferencePath,
    both_or_held,
    motion_experiment,
)

#: speeds of each axis, and of the other one in reverse order so that they can be run together
LOWEST_RAD_S, HIGHEST_RAD_S, SPEEDS, SHORT_SPEEDS = 0.03, 1.5, 8, 6
#: each speed for so long each way, within this travel
PASS_S, TRAVEL_RAD = 2.5, 1.4


def build(options: SequenceOptions) -> Experiment:
    """All speeds, each there and back, on the axes asked for."""
    speeds = np.geomspace(LOWEST_RAD_S, HIGHEST_RAD_S, SHORT_SPEEDS if options.short else SPEEDS).tolist()
    paths = options.by_axis((_passes(speeds), _passes(speeds[::-1])))
    said = "Each speed there and back: what is even in speed, odd in it, and how it grows show apart."
    return motion_experiment(
        "plateaus", "Constant speeds in both directions", options, both_or_held(options, paths), said
    )


def _passes(speeds: list[float]) -> Floats:
    path = ReferencePath.at(0.0).wait(0.5)
    for number, speed in enumerate(speeds):
        travel = min(PASS_S * speed, TRAVEL_RAD)
        side = 1.0 if number % 2 == 0 else -1.0
        # fast passes are short: they are made from one end of the travel to the other, twice
        if travel < TRAVEL_RAD:
            path.pass_at(speed, side * travel)
        else:
            half = 0.5 * TRAVEL_RAD
            path.to(-side * half, 1.5).pass_at(speed, side * TRAVEL_RAD).pass_at(speed, side * TRAVEL_RAD).to(0.0, 1.5)
    return path.sampled(path.end_s + 0.5)
