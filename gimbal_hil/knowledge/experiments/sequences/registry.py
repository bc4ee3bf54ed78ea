"""Sequence names and the files that build them; a sequence is imported when it is asked for."""

from __future__ import annotations

import importlib
from pathlib import Path

from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.experiments import Experiment
from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions

#: name -> what it measures; the module of that name defines `build(options) -> Experiment`
SEQUENCES = {
    "step": "step responses of both axes: overshoot, settling, steady-state error",
    "sliding": "mean torque at constant speeds, both directions: the friction-velocity curve",
    "presliding": "torque ramps below and through break-away, small loops, a pulse: stiffness and damping",
    "gravity_map": "holding torque over the travel, approached from both sides",
    "sweep": "frequency response of the rate loop, open and closed, with margins and coherence",
    "base_motion": "position hold while the base moves",
    "warm_up": "friction while the joint warms up",
    "survey": "rich motion of both axes, for finding what the model lacks",
    "survey_holdout": "another rich motion, to judge on what was found",
    "plateaus": "constant speeds over a decade and a half, both directions: kinds of drag apart",
    "full_turn": "the whole travel at two speeds: spring or unbalance, cogging or eccentric encoder",
    "creep": "below the Stribeck speed and below break-away: Stribeck bump or bristles",
    "reversals": "reversals of many sizes: a gap or bristles; inertia, lag, delay",
    "two_loads": "the same motion in several poses: torque gain or friction that grows with load",
    "one_locked": "one axis driven, the other locked: coupling of bodies or of the gyro",
    "warm_and_cool": "plateaus while warming up and cooling down: temperature or wear",
}


def build_experiment(name: str, options: SequenceOptions) -> Experiment:
    """The experiment of that name; BadInputError lists the names."""
    if name.endswith((".yaml", ".yml")):
        from gimbal_hil.knowledge.experiments import experiment_of_file

        return experiment_of_file(Path(name), options.rate_hz, options.every, options.names)
    if name not in SEQUENCES:
        raise BadInputError(
            f"experiment {name!r}",
            "is no sequence and no plan file",
            ", ".join([*SEQUENCES, "thesis", "or a plan file"]),
        )
    experiment: Experiment = importlib.import_module(f"gimbal_hil.knowledge.experiments.sequences.{name}").build(
        options
    )
    return experiment
