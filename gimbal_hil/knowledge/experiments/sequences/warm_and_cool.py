"""The same plateaus cold, while warming up at speed, and while cooling down: tells temperature from wear and from plain
viscosity.
"""

from __future__ import annotations

from gimbal_hil.knowledge.experiments import Experiment
from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions
from gimbal_hil.knowledge.experiments.sequences.reference_motion import (
    Floats,
    ReferencePath,
    both_or_held,
    motion_experiment,
)

#: plateaus of these speeds, in between either heating at this one or waiting, so long each
SPEEDS_RAD_S, TRAVEL_RAD = (0.3, 1.2), 1.2
HEATING_RAD_S, PERIOD_S, SHORT_PERIOD_S, PERIODS = 1.5, 45.0, 12.0, 2


def build(options: SequenceOptions) -> Experiment:
    """Plateaus, heating, plateaus, heating, plateaus, waiting, plateaus, waiting, plateaus on the axes asked for."""
    period = SHORT_PERIOD_S if options.short else PERIOD_S
    paths = {axis: _cycle(period) for axis in options.names}
    said = (
        "The same plateaus at several temperatures, on the way up and down: temperature goes both ways, wear only one."
    )
    return motion_experiment(
        "warm_and_cool", "Plateaus while warming up and cooling down", options, both_or_held(options, paths), said
    )


def _cycle(period_s: float) -> Floats:
    path = ReferencePath.at(-0.5 * TRAVEL_RAD).wait(0.5)
    _plateaus(path)
    for _ in range(PERIODS):
        for _ in range(max(1, round(period_s * HEATING_RAD_S / (2.0 * TRAVEL_RAD)))):
            path.pass_at(HEATING_RAD_S, TRAVEL_RAD)
        _plateaus(path)
    for _ in range(PERIODS):
        path.wait(period_s)
        _plateaus(path)
    return path.sampled(path.end_s + 0.5)


def _plateaus(path: ReferencePath) -> None:
    for speed in SPEEDS_RAD_S:
        path.pass_at(speed, TRAVEL_RAD)
