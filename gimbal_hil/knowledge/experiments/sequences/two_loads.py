"""The same motion in several poses: gravity loads the joint differently in each, so that gain, load and place show
apart.
"""

from __future__ import annotations

import numpy as np

from gimbal_hil.knowledge.experiments import Experiment
from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions
from gimbal_hil.knowledge.experiments.sequences.reference_motion import ROW_S, Floats, ReferencePath, motion_experiment

#: the poses of each axis (rad), and the motion about each: a slow pass of this travel, then a sine
POSES_RAD = ((-1.2, 0.4, 1.2), (1.2, -0.2, -1.2))
TRAVEL_RAD, SPEED_RAD_S, SHORT_SPEED_RAD_S = 0.3, 0.1, 0.2
SINE_RAD, SINE_HZ, SINE_S, BETWEEN_S = 0.06, 1.5, 3.0, 3.0


def build(options: SequenceOptions) -> Experiment:
    """The same motion of both axes in each pose; the axis that was not asked for only changes its pose."""
    speed = SHORT_SPEED_RAD_S if options.short else SPEED_RAD_S
    references = {
        axis: _posed(poses, speed, axis in options.axes) for axis, poses in options.by_axis(POSES_RAD).items()
    }
    said = "A gain error and friction that grows with load change from pose to pose; plain friction and inertia do not."
    return motion_experiment("two_loads", "The same motion under several loads", options, references, said)


def _posed(poses: tuple[float, ...], speed: float, moving: bool) -> Floats:
    path = ReferencePath.at(0.0)
    starts = []
    for pose in poses:
        path.to(pose, BETWEEN_S)
        travel = TRAVEL_RAD / speed
        if moving:
            path.pass_at(speed, TRAVEL_RAD)
        else:
            path.wait(2.0 * travel)
        starts.append(path.end_s)
        path.wait(SINE_S)
    path.to(0.0, BETWEEN_S)
    reference = path.sampled(path.end_s + 0.5)
    t = np.arange(len(reference)) * ROW_S
    for start in starts if moving else ():
        inside = np.clip(np.minimum(t - start, start + SINE_S - t) / 0.3, 0.0, 1.0)
        reference = reference + inside * SINE_RAD * np.sin(2.0 * np.pi * SINE_HZ * (t - start))
    return np.asarray(reference, dtype=np.float64)
