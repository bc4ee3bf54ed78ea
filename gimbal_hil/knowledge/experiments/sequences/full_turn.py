"""The whole travel at two speeds in both directions: spring or unbalance, cogging or eccentric encoder or uneven
friction.
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

#: half of the travel (rad): a turn of the carrying axis, what its stops allow of the carried one
HALF_RAD = (3.2, 1.8)
#: slow and fast
SPEEDS_RAD_S = ((0.6, 1.6), (0.35, 1.0))
SHORT_SPEEDS_RAD_S = ((0.9, 1.8), (0.6, 1.2))


def build(options: SequenceOptions) -> Experiment:
    """Both speeds over the whole travel, there and back, on the axes asked for."""
    half, speeds = options.by_axis(HALF_RAD), options.by_axis(SHORT_SPEEDS_RAD_S if options.short else SPEEDS_RAD_S)
    paths = {axis: _turns(half[axis], speeds[axis]) for axis in options.names}
    said = (
        "A constant torque over position stays as it is at both speeds; what comes from the encoder grows with the "
        "square of the speed."
    )
    return motion_experiment("full_turn", "The whole travel at two speeds", options, both_or_held(options, paths), said)


def _turns(half: float, speeds: tuple[float, float]) -> Floats:
    path = ReferencePath.at(0.0).to(-half, half / 0.7)
    for speed in speeds:
        path.wait(0.5).pass_at(speed, 2.0 * half)
    path.wait(0.5).to(0.0, half / 0.7)
    return path.sampled(path.end_s + 0.5)
