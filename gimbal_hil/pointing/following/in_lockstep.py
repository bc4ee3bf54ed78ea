"""A target followed by the virtual antenna of this process, in lockstep: as fast as the machine allows."""

from __future__ import annotations

from pathlib import Path

from gimbal_hil.knowledge.experiments import (
    Experiment,
    LockstepAntenna,
    Outcome,
    ProgressSink,
    Step,
    run_experiment,
    run_header,
)
from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.pointing.following.way import Way
from sim_backend.model import AntennaModel

#: a target's way is followed in steps of this length, so that what is under way stays small
_STEP_S = 60.0


def follow_in_lockstep(
    way: Way,
    duration_s: float,
    settings: DaemonSettings,
    model: AntennaModel,
    seed: int,
    folder: Path,
    force: bool,
    progress: ProgressSink,
) -> Outcome:
    """Leaves a run folder with frames, which replays; the antenna ends in the middle of its travel, torque off."""
    ticks = round(duration_s * settings.rate_hz)
    each = round(_STEP_S * settings.rate_hz)
    steps = []
    for number, first in enumerate(range(0, ticks, each)):
        segment = way.segment(-1 - first, min(each, ticks - first))
        steps.append(Step(f"minute {number + 1}", segment, every=20))
    experiment = Experiment("point", "Pointing", tuple(steps), lambda step, signals: None, lambda rows, drawn: [])
    header = run_header(settings, model, seed, "point", 1)
    antenna = LockstepAntenna(settings, model, seed, 1)
    try:
        return run_experiment(experiment, antenna, folder, header, force=force, progress=progress)
    finally:
        antenna.close()
