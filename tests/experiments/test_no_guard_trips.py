"""The shipped experiments ask nothing that trips a guard of the shipped configuration, with half of what the guards
allow.
"""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, build_experiment
from gimbal_hil.loop.host import HostState, program_of
from gimbal_hil.loop.host.layout import AXES, DISTURBANCE, MAX_DISAGREEMENT, MAX_DRIFT, axis_c
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.realtime.lockstep import CompiledPath
from sim_backend.model import shipped_model

BREAKAWAY = {"outer": 0.2585, "inner": 0.1451}
#: those with the largest torques, rates and base motions, and how the base moves
DEMANDS = (
    *(("base_motion", f"3.1/{case}") for case in range(1, 6)),
    *(("base_motion", f"3.2/{case}") for case in range(1, 5)),
    *(
        (name, None)
        for name in ("step", "sweep", "survey", "survey_holdout", "reversals", "two_loads", "one_locked", "full_turn")
    ),
    *((name, None) for name in ("plateaus", "creep", "gravity_map")),
)


@pytest.mark.parametrize(("name", "base"), DEMANDS)
def test_a_shipped_experiment_trips_nothing(name: str, base: str | None) -> None:
    experiment = build_experiment(name, SequenceOptions(1000.0, short=True, base=base, breakaway_nm=BREAKAWAY))
    model = shipped_model() if experiment.base is None else shipped_model().with_base(experiment.base)
    path = CompiledPath(shipped_settings(), model, seed=3)
    for axis in range(AXES):
        path.host.memory.C[np.array([DISTURBANCE, MAX_DRIFT, MAX_DISAGREEMENT]) + axis_c(axis)] *= 0.5
    path.connect()
    for step in experiment.steps:
        ran = path.run(program_of([step.segment]), every=1000)
        done = HostState.IDLE if step.segment.switch_off_afterwards else HostState.ACTIVE
        assert path.host.state in (done, HostState.STOPPING), (step.name, [event.text for event in ran.events])


@pytest.mark.parametrize("axis", ["outer", "inner"])
@pytest.mark.parametrize("antiresonance_hz", [5.0, 10.0, 20.0, 40.0])
def test_a_resonance_that_answers_the_wrong_way_round_is_no_motor_turned_round(
    axis: str, antiresonance_hz: float
) -> None:
    hung = {"antiresonance_frequency": antiresonance_hz, "damping_ratio": 0.01, "inertia_share": 0.6}
    experiment = build_experiment("sweep", SequenceOptions(1000.0, short=True, breakaway_nm=BREAKAWAY))
    path = CompiledPath(shipped_settings(), shipped_model().with_effect("structural_resonance", axis, hung), seed=3)
    path.connect()
    for step in experiment.steps:
        ran = path.run(program_of([step.segment]), every=1000)
        assert path.host.state is not HostState.FAULT, (step.name, [event.text for event in ran.events])
