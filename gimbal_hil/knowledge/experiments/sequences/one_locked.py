"""One axis driven while the other holds an angle, then the other one, at two angles: coupling of bodies or of the
gyro.
"""

from __future__ import annotations

import numpy as np

from gimbal_hil.knowledge.experiments import Experiment
from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions
from gimbal_hil.knowledge.experiments.sequences.reference_motion import ROW_S, ReferencePath, motion_experiment

#: angle at which the axis that is not driven holds (rad), speeds of the driven one (rad/s), its travel (rad), then
#: quick sines
HELD_RAD, TRAVEL_RAD = 0.9, 1.2
SPEEDS_RAD_S, SHORT_SPEEDS_RAD_S = (0.4, 1.2), (1.2,)
SINE_RAD, SINE_HZ, SINE_S, BETWEEN_S = 0.06, 2.2, 4.0, 2.5


def build(options: SequenceOptions) -> Experiment:
    """The axes asked for are driven in turn, the other one holding at plus and minus an angle."""
    speeds = SHORT_SPEEDS_RAD_S if options.short else SPEEDS_RAD_S
    paths = {axis: ReferencePath.at(0.0).wait(0.5) for axis in options.names}
    sines: list[tuple[str, float]] = []
    for driven in options.axes:
        other = options.other(driven)
        for held in (HELD_RAD, -HELD_RAD):
            paths[other].to(held, BETWEEN_S)
            paths[driven].to(-0.5 * TRAVEL_RAD, BETWEEN_S)
            for speed in speeds:
                paths[driven].pass_at(speed, TRAVEL_RAD)
            sines.append((driven, paths[driven].end_s))
            paths[driven].wait(SINE_S)
            paths[other].wait(paths[driven].end_s - paths[other].end_s)
        for axis in options.names:
            paths[axis].to(0.0, BETWEEN_S)
    references = {axis: paths[axis].sampled(paths[axis].end_s + 0.5) for axis in options.names}
    for driven, start in sines:
        t = np.arange(len(references[driven])) * ROW_S
        inside = np.clip(np.minimum(t - start, start + SINE_S - t) / 0.3, 0.0, 1.0)
        references[driven] = references[driven] + inside * SINE_RAD * np.sin(2.0 * np.pi * SINE_HZ * (t - start))
    said = (
        "What one axis does to the other at rest: products of inertia act on its torque, a misaligned gyro on its "
        "rate alone."
    )
    return motion_experiment("one_locked", "One axis driven, the other locked", options, references, said)
